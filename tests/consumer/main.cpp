// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstring>

#include <covis/version.h>

int main() {
  std::printf("covis %s\n", covis::version());
  return std::strcmp(covis::version(), COVIS_VERSION) == 0 ? 0 : 1;
}
