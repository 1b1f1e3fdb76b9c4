// SPDX-License-Identifier: Apache-2.0
// One description of every setting: an Options struct lists its fields once (`Fields fields(OrbOptions&)`), and from that
// list come the YAML keys, their range checks, --dump-config and the documentation.
#pragma once

#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace covis {

struct Field {
  std::string name;                                             // key, for example "orb.features"
  std::variant<int*, double*, bool*, std::string*> value;       // where it is read from and written to
  std::string doc;                                              // what it does, with its unit
  double min = std::numeric_limits<double>::lowest();           // least and greatest value allowed (numbers)
  double max = std::numeric_limits<double>::max();
};

using Fields = std::vector<Field>;

}  // namespace covis
