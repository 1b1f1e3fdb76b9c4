// SPDX-License-Identifier: Apache-2.0
// The settings of the system by name, as `covis run --dump-config` lists them. Timing and mode are members of
// SlamOptions.
#pragma once

#include <string>
#include <vector>

#include "covis/export.h"

namespace covis {

enum class SettingType { whole_number, number, boolean, text };

struct Setting {
  std::string name;  // for example "orb.features"
  SettingType type = SettingType::number;
  std::string value;        // as text, as it can be given to Slam::create()
  double min = 0, max = 0;  // the least and the greatest value allowed; of numbers only. The
                            // description names one outside of them that has a meaning of its own.
  std::string description;  // effect, with its unit
};

// All settings with their defaults.
COVIS_API std::vector<Setting> default_settings();

}  // namespace covis
