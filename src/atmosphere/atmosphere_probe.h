#pragma once
#include <memory>
#include <span>
#include <vector>

#include "atmosphere/atmosphere_probe_shared.h"
#include "atmosphere/atmosphere_tables.h"
#include "gpu/graph_executor.h"
#include "gpu/pipeline.h"

namespace nepho {

/// Asks the functions of shaders/atmosphere/atmosphere_lookup.glsl, which frames use, on the device: for tests and
/// `nepho probe`. A sky view is integrated for every camera and sun among the cases, as a frame does for its own.
class AtmosphereProbe {
 public:
  using Case = shared::AtmosphereCase;
  using Answer = shared::AtmosphereAnswer;

  AtmosphereProbe(gpu::Device& device, std::shared_ptr<const AtmosphereTables> tables);
  /// `kind` is one of kProbe... (atmosphere_probe_shared.h). The cases' `view` is ignored.
  std::vector<Answer> ask(uint32_t kind, std::span<const Case> cases);
  const AtmosphereTables& tables() const { return *tables_; }

 private:
  std::vector<Answer> ask_batch(uint32_t kind, std::vector<Case> cases, std::span<const shared::SkyView> views);

  std::shared_ptr<const AtmosphereTables> tables_;
  gpu::GraphExecutor executor_;
  gpu::ComputePipeline pipeline_;
};

}  // namespace nepho
