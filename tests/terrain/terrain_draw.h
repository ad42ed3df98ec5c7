#pragma once
#include <vector>

#include "gpu/gpu_fixture.h"
#include "terrain/terrain.h"

namespace nepho::test {

/// What the terrain's passes leave of a view.
struct DrawnTerrain {
  std::vector<float> depth_m;
  std::vector<uint16_t> albedo, normal;  ///< halves, four a pixel
};

/// Draws a view with the terrain's passes alone.
inline DrawnTerrain draw_terrain(GpuFixture& gpu, Terrain& terrain, FrameInfo frame, const TerrainWait& wait = {}) {
  terrain.prepare(frame, wait);
  FrameGraph graph;
  frame.buffer = graph.constants("frame", frame.constants);
  const Terrain::Outputs out = terrain.add(graph, frame);
  for (const ImageRef image : {out.depth_m, out.albedo, out.normal}) graph.keep(image);
  gpu.executor.run(graph);
  return {gpu.executor.read<float>(out.depth_m), gpu.executor.read<uint16_t>(out.albedo),
          gpu.executor.read<uint16_t>(out.normal)};
}

}  // namespace nepho::test
