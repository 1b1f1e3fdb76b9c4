// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/join_report.h"

namespace covis {

const char* name(JoinRefusal refusal) {
  switch (refusal) {
    case JoinRefusal::none:
      return "joined";
    case JoinRefusal::not_alike:
      return "no place looks alike";
    case JoinRefusal::not_verified:
      return "no place that looks alike is the same";
    case JoinRefusal::unconfirmed:
      return "too few views show the same place";
    case JoinRefusal::too_small:
      return "one map has fewer than five key frames";
    case JoinRefusal::ambiguous:
      return "places that look alike contradict one another";
    case JoinRefusal::contradicted:
      return "views that would stand side by side do not see the same";
    case JoinRefusal::inconsistent:
      return "both are joined with others in another way";
  }
  return "";
}

}  // namespace covis
