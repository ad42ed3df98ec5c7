#include "clouds/cloud_probe.h"

#include <cmath>
#include <limits>

#include "clouds/probe_column.comp.h"
#include "clouds/probe_density.comp.h"
#include "clouds/probe_weather.comp.h"
#include "geo/frames.h"
#include "geo/planet_view.h"
#include "gpu/commands.h"

namespace nepho {
namespace {

static_assert(sizeof(shared::CloudCase) == sizeof(shared::PlanetView) + 16 + sizeof(shared::CloudAnchor));

/// Cases of one dispatch: buffers stay below 128 MiB.
constexpr size_t kBatch = 65536;

shared::CloudCase make_case(const Clouds& clouds, const CloudProbe::Case& from) {
  const dvec3 point = ecef_from_geodetic(from.point);
  // Two metres towards the Earth's axis: a camera at the very point has no direction to it, which nothing here needs,
  // but a shader may normalise.
  const dvec3 camera = from.camera ? ecef_from_geodetic(*from.camera) : point - dvec3(2.0, 0.0, 0.0);
  shared::CloudCase c{};
  c.planet = make_planet_view(camera);
  c.p_cam = glm::vec3(point - camera);
  c.footprint_m = static_cast<float>(from.footprint_m);
  c.anchor = clouds.anchor(camera, from.time_s);
  return c;
}

struct WeatherAnswer {
  glm::vec4 coverage, properties;
};
struct DensityAnswer {
  glm::vec4 density;
  float extinction_per_m;
};
struct ColumnAnswer {
  glm::vec4 optical_depth;
  float base_m, top_m;
};

}  // namespace

CloudProbe::CloudProbe(gpu::Device& device, const Clouds& clouds)
    : executor_(device),
      clouds_(clouds),
      weather_(device, {.name = "probe.weather", .spirv = probe_weather_comp, .constants = clouds.specialisation(2)}),
      density_(device, {.name = "probe.density", .spirv = probe_density_comp, .constants = clouds.specialisation(2)}),
      column_(device, {.name = "probe.column", .spirv = probe_column_comp, .constants = clouds.specialisation(2)}) {}

template <typename Answer>
std::vector<Answer> CloudProbe::run(const gpu::ComputePipeline& pipeline, const std::vector<Case>& cases) {
  std::vector<Answer> answers;
  answers.reserve(cases.size());
  for (size_t first = 0; first < cases.size(); first += kBatch) {
    const size_t count = std::min(kBatch, cases.size() - first);
    std::vector<shared::CloudCase> batch(count);
    for (size_t i = 0; i < count; ++i) batch[i] = make_case(clouds_, cases[first + i]);
    FrameGraph graph;
    const CloudDensityRefs refs{.constants = graph.constants("clouds.constants", clouds_.constants()),
                                .weather = clouds_.weather().import_into(graph),
                                .noise = clouds_.noise().import_into(graph)};
    const BufferRef in = graph.constants("probe.cases", batch);
    const BufferRef out = graph.create_buffer("probe.answers", count * sizeof(Answer));
    FrameGraph::PassBuilder pass = graph.pass("clouds.probe");
    bind_density(pass, refs);
    const auto threads = static_cast<uint32_t>(count);
    pass.read("cases", in).write("answers", out).record([&pipeline, threads](gpu::Commands& cmd) {
      cmd.bind(pipeline).push(threads).dispatch_threads(threads, 1);
    });
    graph.keep(out);
    executor_.run(graph);
    const std::vector<Answer> some = executor_.read<Answer>(out);
    answers.insert(answers.end(), some.begin(), some.end());
  }
  return answers;
}

std::vector<CloudProbe::Weather> CloudProbe::weather(const std::vector<Case>& cases) {
  std::vector<Weather> out;
  for (const WeatherAnswer& a : run<WeatherAnswer>(weather_, cases))
    out.push_back({a.coverage, a.properties.x, a.properties.y, a.properties.z, a.properties.w});
  return out;
}

std::vector<CloudProbe::Density> CloudProbe::density(const std::vector<Case>& cases) {
  if (clouds_.constants().layer_count == 0) return std::vector<Density>(cases.size());  // as the march: no layers
  std::vector<Density> out;
  for (const DensityAnswer& a : run<DensityAnswer>(density_, cases)) out.push_back({a.density, a.extinction_per_m});
  return out;
}

std::vector<CloudProbe::Column> CloudProbe::column(const std::vector<Case>& cases) {
  std::vector<Column> out;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  if (clouds_.constants().layer_count == 0)
    return std::vector<Column>(cases.size(), Column{.optical_depth = glm::vec4(0.0f), .base_m = kNone, .top_m = kNone});
  for (const ColumnAnswer& a : run<ColumnAnswer>(column_, cases)) {
    const bool clear = a.base_m > a.top_m;
    out.push_back({a.optical_depth, clear ? kNone : a.base_m, clear ? kNone : a.top_m});
  }
  return out;
}

}  // namespace nepho
