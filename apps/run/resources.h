// SPDX-License-Identifier: Apache-2.0
// Memory and processor time of this process.
#pragma once

namespace covis::app {

double resident_mb();    // resident memory now
double peak_rss_mb();    // its peak so far
double thread_cpu_ms();  // worked by the calling thread since it began

}  // namespace covis::app
