// SPDX-License-Identifier: Apache-2.0
// The single description of every setting: an Options struct lists its fields once (`Fields fields(OrbOptions&)`), and
// the YAML keys, their range checks, --dump-config and the documentation are all derived from that list.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "covis/core/error.h"

namespace covis {

struct Field {
  std::string name;                                        // key, for example "orb.features"
  std::variant<int*, double*, bool*, std::string*> value;  // pointer to the value that is read and written
  std::string doc;                                         // effect of the setting, with its unit
  double min = std::numeric_limits<double>::lowest();      // least and greatest value allowed (numbers only)
  double max = std::numeric_limits<double>::max();
  std::string former = {};          // name in earlier versions; using it is an error whose message gives the new name
  std::optional<double> also = {};  // a value of its own meaning, allowed outside of the range
};

using Fields = std::vector<Field>;

// Sets the field with that name from text. An error names the nearest known field, the new name of a renamed field, or
// the allowed range.
Result<void> set_field(const Fields& fields, std::string_view name, std::string_view text);
// Returns the field's current value in the form that set_field() accepts.
std::string field_text(const Field& field);
// Returns the range as text ("from 1 to 10"), or an empty string when the field has no bound.
std::string field_range(const Field& field);
// Returns the entry of `names` with the smallest edit distance to `name` (the first on a tie), or "" if there are none.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

}  // namespace covis
