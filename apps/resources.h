// SPDX-License-Identifier: Apache-2.0
// What this process uses.
#pragma once

namespace covis::app {

double resident_mb();    // memory now
double peak_rss_mb();    // the most there was
double thread_cpu_ms();  // worked by the calling thread since it began

}  // namespace covis::app
