// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/options.h"

#include <utility>

namespace covis {

Fields fields(SystemOptions& o) {
  Fields all = fields(o.orb);
  for (Field& field : fields(o.tracker)) all.push_back(std::move(field));
  for (Field& field : fields(o.mapper)) all.push_back(std::move(field));
  for (Field& field : fields(o.loop)) all.push_back(std::move(field));
  all.push_back(
      {"system.mapping_delay", &o.mapping_delay,
       "frames after a key frame at which its mapping becomes visible to tracking, unless few points are left", 1,
       100});
  all.push_back({"system.realtime", &o.realtime, "frames at their own times, mapping visible when ready"});
  all.push_back({"system.localize", &o.localize, "localisation only: no key frames, no points; needs a map"});
  all.push_back({"system.trajectory_frames", &o.trajectory_frames,
                 "newest frames whose poses are kept, for programs that run on and on; 0: all", 0, 100'000'000});
  all.push_back({"system.seed", &o.seed, "seed of the random choices", 0, 2147483647.0});
  return all;
}

}  // namespace covis
