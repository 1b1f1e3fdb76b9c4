// SPDX-License-Identifier: Apache-2.0
// Prints on posters, books, screens and labels: pictures and small print, each filling a box of a canvas.
#pragma once

#include "covis/core/random.h"
#include "synth/render/canvas.h"

namespace covis::synth {

void print_text(Canvas& c, Random& random, double x0, double y0, double x1, double y1, double height, double tone);
void landscape(Canvas& c, Random& random, double x0, double y0, double x1, double y1);
void abstract(Canvas& c, Random& random, double x0, double y0, double x1, double y1);
void portrait(Canvas& c, Random& random, double x0, double y0, double x1, double y1);
void chart(Canvas& c, Random& random, double x0, double y0, double x1, double y1);

}  // namespace covis::synth
