// SPDX-License-Identifier: Apache-2.0
// Memory and processor time of this process.
#pragma once

namespace covis::app {

double resident_mb();    // current resident memory
double peak_rss_mb();    // peak resident memory so far
double thread_cpu_ms();  // processor time of the calling thread since its start

}  // namespace covis::app
