// SPDX-License-Identifier: Apache-2.0
#include "covis/version.h"

namespace covis {

const char* version() { return COVIS_VERSION; }

}  // namespace covis
