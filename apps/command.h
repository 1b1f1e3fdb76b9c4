// SPDX-License-Identifier: Apache-2.0
// The covis command, for its main() and for tests.
#pragma once

// Returns the exit code. It changes the process as a command may (signal handlers, log sink), so call it once in a
// process.
int covis_command(int argc, char** argv);
