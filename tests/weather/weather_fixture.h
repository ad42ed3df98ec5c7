#pragma once
#include <cstdlib>
#include <filesystem>
#include <glm/vec4.hpp>
#include <vector>

#include "gpu/commands.h"
#include "gpu/gpu_fixture.h"
#include "gpu/pipeline.h"
#include "io/array_raster.h"
#include "io/file_test_tools.h"
#include "weather/cube_field.h"
#include "weather/test_cube.comp.h"

namespace nepho::test {

/// A cache folder of this test's own, empty.
struct CacheFolder {
  CacheFolder() { setenv("NEPHO_CACHE", folder.path().c_str(), 1); }
  ~CacheFolder() { unsetenv("NEPHO_CACHE"); }
  TempFolder folder;
};

/// What a seamless cube sampler reads in directions (xyz) at a level of detail (w).
inline std::vector<glm::vec4> sample_cube(GpuFixture& gpu, const gpu::Image& cube, const std::vector<glm::vec4>& at) {
  const gpu::ComputePipeline pipeline(gpu.device, {.name = "test.cube", .spirv = test_cube_comp});
  FrameGraph graph;
  const BufferRef directions = graph.constants("directions", at);
  const BufferRef values = graph.create_buffer("values", at.size() * sizeof(glm::vec4));
  graph.pass("test.cube")
      .sample("cube_tex", graph.import(cube))
      .read("directions", directions)
      .write("values", values)
      .record([&](gpu::Commands& cmd) { cmd.bind(pipeline).dispatch_threads(static_cast<uint32_t>(at.size())); });
  graph.keep(values);
  gpu.executor.run(graph);
  return gpu.executor.read<glm::vec4>(values);
}

/// Scaled direction of a geodetic place.
inline dvec3 map_direction(double lat_deg, double lon_deg) {
  return map_direction_from_ecef(ecef_from_geodetic(Geodetic::from_degrees(lat_deg, lon_deg)));
}

/// A raster of `bands` equal bands, from a function of latitude and longitude in degrees.
template <typename F>
std::shared_ptr<Raster> make_field(uint32_t width, uint32_t height, LonLatBounds bounds, F&& value,
                                   uint32_t bands = 1) {
  RasterInfo info{.path = "field.tif", .width = width, .height = height, .bands = bands, .bounds = bounds};
  info.wraps = bounds.east_deg - bounds.west_deg == 360.0;
  std::vector<float> values;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const double lat = bounds.north_deg - (y + 0.5) * (bounds.north_deg - bounds.south_deg) / height;
      const double lon = bounds.west_deg + (x + 0.5) * (bounds.east_deg - bounds.west_deg) / width;
      for (uint32_t b = 0; b < bands; ++b) values.push_back(static_cast<float>(value(lat, lon)));
    }
  return std::make_shared<ArrayRaster>(std::move(info), std::move(values));
}

}  // namespace nepho::test
