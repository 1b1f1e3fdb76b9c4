// SPDX-License-Identifier: Apache-2.0
// Work that nobody waits for at once gives way to tracking when there are more busy threads than cores.
#pragma once

namespace covis {

// From now on the calling thread, and those it makes, get a third of the time of a thread of usual priority they share
// a core with; all of it when the core is free. Where threads have no priorities of their own nothing happens.
void lower_thread_priority();

}  // namespace covis
