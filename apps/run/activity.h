// SPDX-License-Identifier: Apache-2.0
// The task of the command, for the message when it ends because memory or threads run out, in whichever thread.
#pragma once

#include <cstdint>
#include <string>

namespace covis::app {

// The command's words as they were given, up to the first option: "covis run desk". Before any thread is started.
void set_activity(int argc, const char* const* argv);
// A part of it: "while the results are written". `part` must be there for ever.
void enter_part(const char* part);
void enter_frame(int64_t frame);

// "covis run desk, frame 7".
std::string current_activity();

// Makes an exception that nothing can catch (in a thread, in a library that is being loaded) end the process with one
// message that says what was being done: with 1 where memory or threads have run out, else, as after any error of the
// program's, by SIGABRT. Files are written whole or not at all, so that older ones stay.
void end_in_order_on_terminate();

}  // namespace covis::app
