// SPDX-License-Identifier: Apache-2.0
// Lists the settings with what they mean, or makes a system with others than the defaults.
//   own_settings                                  lists them
//   own_settings orb.features=2000 loop.close=false
#include <covis/covis.h>

#include <cstdio>
#include <string>

int main(int argc, char** argv) {
  covis::SlamOptions options{
      .sensor = covis::SensorType::monocular,
      .camera = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240},
  };
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const size_t at = argument.find('=');
    if (at == std::string::npos) return std::fprintf(stderr, "%s: NAME=VALUE is wanted\n", argv[i]), 1;
    options.settings.emplace_back(argument.substr(0, at), argument.substr(at + 1));
  }
  const auto slam = covis::Slam::create(options);
  if (!slam) return std::fprintf(stderr, "%s\n", slam.error().c_str()), 1;
  for (const covis::Setting& setting : (*slam)->settings())
    std::printf("%-40s %-10s %s\n", setting.name.c_str(), setting.value.c_str(), setting.description.c_str());
}
