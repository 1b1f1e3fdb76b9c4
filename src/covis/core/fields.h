// SPDX-License-Identifier: Apache-2.0
// One description of every setting: an Options struct lists its fields once (`Fields fields(OrbOptions&)`), and from
// that list come the YAML keys, their range checks, --dump-config and the documentation.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "covis/core/error.h"

namespace covis {

struct Field {
  std::string name;                                        // key, for example "orb.features"
  std::variant<int*, double*, bool*, std::string*> value;  // the variable that is read and written
  std::string doc;                                         // its effect, with its unit
  double min = std::numeric_limits<double>::lowest();      // least and greatest value allowed (numbers)
  double max = std::numeric_limits<double>::max();
};

using Fields = std::vector<Field>;

// Sets the field of that name from text. Errors name the nearest known field, or the range.
Result<void> set_field(const Fields& fields, std::string_view name, std::string_view text);
// The field's present value as set_field() takes it.
std::string field_text(const Field& field);
// "from 1 to 10"; empty when there is no bound.
std::string field_range(const Field& field);
// The one of `names` with the fewest letters to change to `name` (the first on a tie); empty when there are none.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

}  // namespace covis
