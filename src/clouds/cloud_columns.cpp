#include "clouds/cloud_columns.h"

#include "clouds/cloud_columns.comp.h"
#include "gpu/commands.h"

namespace nepho {

static_assert(sizeof(shared::CloudColumnsPush) == 40);
constexpr uint32_t kColumnSteps = 56;  // 29 m in a layer of 1600 m

CloudColumns::CloudColumns(gpu::Device& device)
    : pipeline_(device, {.name = "clouds.columns", .spirv = cloud_columns_comp}) {}

ImageRef CloudColumns::add(FrameGraph& graph, const FrameInfo& frame, const CloudDensityRefs& density,
                           const Square& square) const {
  const ImageRef out = graph.create("clouds.columns", {.extent = {square.count, square.count}, .format = Format::r32f});
  const shared::CloudColumnsPush push{
      square.east,  square.north, static_cast<float>(square.side_m), static_cast<float>(square.footprint_m),
      square.count, kColumnSteps};
  FrameGraph::PassBuilder pass = graph.pass("clouds.columns");
  pass.uniform("frame", frame.buffer);
  bind_density(pass, density);
  pass.write("out_depth", out).record([this, push](gpu::Commands& cmd) {
    cmd.bind(pipeline_).push(push).dispatch_threads(push.count, push.count);
  });
  return out;
}

}  // namespace nepho
