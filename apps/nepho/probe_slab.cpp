#include "clouds/traced_slabs.h"
#include "gpu/device.h"
#include "probe_tables.h"

namespace nepho {

namespace {

/// Beyond, everything is opaque to six digits; and the scene's extinction ends there.
constexpr double kMostTau = 1000.0;

std::vector<Slab> read_slabs(const ProbeTable& in) {
  std::vector<Slab> slabs;
  slabs.reserve(in.rows());
  for (size_t row = 0; row < in.rows(); ++row) {
    const auto checked = [&](const char* column, auto good, const char* wanted) {
      const double value = in.numbers(column)[row];
      if (!good(value)) throw in.bad_cell(row, column, fmt::format("{} is not {}", value, wanted));
      return value;
    };
    slabs.push_back({.tau = checked(
                         "tau", [](double v) { return v > 0.0 && v <= kMostTau; }, "above 0 and at most 1000"),
                     .single_scattering_albedo = checked(
                         "omega0", [](double v) { return v >= 0.0 && v <= 1.0; }, "within 0..1"),
                     .g = checked(
                         "g", [](double v) { return v > -1.0 && v < 1.0; }, "between -1 and 1, both excluded"),
                     .mu0 = checked(
                         "mu0", [](double v) { return v > 0.0 && v <= 1.0; }, "above 0 and at most 1")});
  }
  return slabs;
}

std::vector<ProbeColumn> columns_of(const std::vector<SlabLight>& lights) {
  std::vector<ProbeColumn> columns;
  const auto add = [&](const std::string& name, auto value) {
    ProbeColumn column{name, {}};
    column.values.reserve(lights.size());
    for (const SlabLight& light : lights) column.values.push_back(value(light));
    columns.push_back(std::move(column));
  };
  add("reflectance", [](const SlabLight& l) { return l.reflectance; });
  add("transmittance_direct", [](const SlabLight& l) { return l.transmittance_direct; });
  add("transmittance_diffuse", [](const SlabLight& l) { return l.transmittance_diffuse; });
  for (size_t i = 0; i < kSlabDirections; ++i)
    add(slab_directions()[i].name(), [i](const SlabLight& l) { return l.radiance[i]; });
  return columns;
}

std::vector<ProbeColumn> evaluate(const ProbeTable& in, const ProbeOptions& options) {
  const std::vector<Slab> slabs = read_slabs(in);
  std::vector<SlabLight> lights;
  if (!slabs.empty()) {
    gpu::Device device({.device = options.device});
    const RenderParams& render = options.scene.render;
    lights = render.quality == "reference"
                 ? TracedSlabs(device, render.noise, render.seed).solve(slabs)
                 : MarchedSlabs(device, options.scene.clouds.multiple_scattering).solve(slabs);
  }
  return columns_of(lights);
}

}  // namespace

std::vector<ProbeKind> slab_probe_kinds() { return {{"slab", {{"tau"}, {"omega0"}, {"g"}, {"mu0"}}, evaluate}}; }

}  // namespace nepho
