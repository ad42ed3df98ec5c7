#include "atmosphere/atmosphere_probe.h"

#include <cstring>

#include "atmosphere/atmosphere_probe.comp.h"
#include "atmosphere/sky_view.h"
#include "gpu/commands.h"

namespace nepho {

namespace {

/// A batch ends when either is reached: the image of the sky views must stay within 16384 texels on a side.
constexpr size_t kViewsPerBatch = 1024, kCasesPerBatch = 65536;

struct Push {
  uint32_t kind, count;
};

bool asks_the_sky(uint32_t kind) { return kind == shared::kProbeSkyRadiance || kind == shared::kProbeLuminance; }

bool same_place_and_sun(const AtmosphereProbe::Case& a, const AtmosphereProbe::Case& b) {
  return std::memcmp(&a.planet, &b.planet, sizeof(a.planet)) == 0 && a.camera_up == b.camera_up &&
         a.sun_dir == b.sun_dir;
}

}  // namespace

AtmosphereProbe::AtmosphereProbe(gpu::Device& device, std::shared_ptr<const AtmosphereTables> tables)
    : tables_(std::move(tables)),
      executor_(device),
      pipeline_(device, {"atmosphere.probe", atmosphere_probe_comp, {tables_->spectral_groups()}}) {}

std::vector<AtmosphereProbe::Answer> AtmosphereProbe::ask(uint32_t kind, std::span<const Case> cases) {
  std::vector<Answer> answers;
  answers.reserve(cases.size());
  size_t i = 0;
  while (i < cases.size()) {
    std::vector<Case> batch;
    std::vector<size_t> places;  // the case that each view is of
    for (; i < cases.size() && batch.size() < kCasesPerBatch; ++i) {
      Case c = cases[i];
      const bool needs_view = asks_the_sky(kind) && c.hits_ground == 0 && has_sky_view(tables_->uniform(), c.planet);
      if (needs_view && (places.empty() || !same_place_and_sun(cases[places.back()], c))) {
        if (places.size() == kViewsPerBatch) break;
        places.push_back(i);
      }
      c.view = places.empty() ? 0u : static_cast<uint32_t>(places.size() - 1);
      batch.push_back(c);
    }
    std::vector<shared::SkyView> views;
    for (const size_t at : places)
      views.push_back(make_sky_view(tables_->uniform(), cases[at].planet, cases[at].camera_up, cases[at].sun_dir,
                                    static_cast<int>(views.size()), static_cast<int>(places.size())));
    const std::vector<Answer> some = ask_batch(kind, std::move(batch), views);
    answers.insert(answers.end(), some.begin(), some.end());
  }
  return answers;
}

std::vector<AtmosphereProbe::Answer> AtmosphereProbe::ask_batch(uint32_t kind, std::vector<Case> cases,
                                                                std::span<const shared::SkyView> views) {
  const auto count = static_cast<uint32_t>(cases.size());
  FrameGraph graph;
  const AtmosphereTables::Refs refs = tables_->add(graph, views);
  const BufferRef in = graph.constants("cases", cases);
  const BufferRef out = graph.create_buffer("answers", cases.size() * sizeof(Answer));
  graph.keep(out);
  auto pass = graph.pass("atmosphere.probe");
  AtmosphereTables::bind(pass, refs, AtmosphereTables::Views::many);
  pass.read("cases", in).write("answers", out).record([this, kind, count](gpu::Commands& cmd) {
    cmd.bind(pipeline_).push(Push{kind, count}).dispatch_threads(count);
  });
  executor_.run(graph);
  return executor_.read<Answer>(out);
}

}  // namespace nepho
