// SPDX-License-Identifier: Apache-2.0
// A process gives up rights for good before it reads files that others made (docs/security.md): should one of them take
// it over, it can't do more than spoil its own results.
#pragma once

#include <string>
#include <vector>

#include "covis/core/error.h"

namespace covis::app {

// From the call on this process and its children write, make and remove files beneath these folders alone (missing ones
// are made, and the first takes temporary files), run no other program, open no socket, and look into no other process.
// Call it before any thread is started. After an error nothing is promised: the system has no Landlock, or Covis was
// built without libseccomp.
Result<void> enter_sandbox(const std::vector<std::string>& writable);

}  // namespace covis::app
