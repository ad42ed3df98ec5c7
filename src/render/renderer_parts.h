#pragma once
// What a renderer is made of; for renderer*.cpp and frame_passes.cpp.
#include <array>
#include <functional>
#include <memory>

#include "atmosphere/air_volume.h"
#include "atmosphere/atmosphere_tables.h"
#include "clouds/cloud_march_pass.h"
#include "clouds/cloud_upscaler.h"
#include "clouds/shadow_map.h"
#include "gpu/graph_executor.h"
#include "render/background_pass.h"
#include "render/debug_views.h"
#include "render/exposure_passes.h"
#include "render/frame_setup.h"
#include "render/ground_shadow_pass.h"
#include "render/night_sky.h"
#include "render/reference_tracer.h"
#include "render/renderer.h"
#include "render/shaft_pass.h"
#include "render/terrain_shadow_pass.h"
#include "terrain/ground_map.h"
#include "terrain/terrain.h"

namespace nepho {

/// What of a frame is wanted.
struct FrameNeeds {
  bool display = false;            ///< the 8-bit picture
  bool layers = false;             ///< all that make_output_layers() takes
  bool work = false;               ///< how many steps the clouds' march took
  bool incomplete_ground = false;  ///< RenderRequest::incomplete_ok
  std::string debug = {};          ///< RenderRequest::debug
  double interval_s = 0.0;         ///< RenderRequest::frame_interval_s
  bool sequence = false;           ///< the picture follows the last one: what still holds may be taken from it
  bool live = false;               ///< RenderRequest::live
};

/// References to what a frame leaves behind; empty where it has none.
struct FrameOutputs {
  ImageRef depth_m, albedo, sun_visibility, background, radiance, cloud, cloud_info, shadow_layers, debug;
  ExposurePasses::Outputs exposure;
  /// Keeps what `needs` asks for, for reading back.
  void keep(FrameGraph& graph, const FrameNeeds& needs) const;
};

struct Renderer::Parts {
  Parts(gpu::Device& device, TerrainSources sources, const SkySources& sky_sources, const WeatherSources& weather,
        const Scene& scene, RenderTimings& timings);
  /// Declares the passes of one frame.
  FrameOutputs add_frame(FrameGraph& graph, const FrameInfo& frame, const Scene& scene, const FrameNeeds& needs);

  /// Light inside clouds, and what they keep from the ground.
  struct CloudLighting {
    CloudLight inside;
    CloudShadowMaps shadows;
  };
  /// Absent under a clear sky, which then costs nothing.
  struct CloudParts {
    CloudParts(gpu::Device& device, const CloudParams& params, const WeatherSources& sources, uint32_t spectral_groups,
               const std::string& quality);
    /// Of live pictures or of others (RenderRequest::live); made when the first picture of its kind wants it.
    CloudLighting& lighting(bool live);
    Clouds clouds;
    GroundMap ground;
    CloudMarchPass march;
    CloudUpscaler upscaler;
    GroundShadowPass shadow;
    DebugViewPass debug;

   private:
    std::function<std::unique_ptr<CloudLighting>(bool live)> make_lighting_;
    std::array<std::unique_ptr<CloudLighting>, 2> lightings_;
  };

  bool software = false;  ///< the device is a CPU
  gpu::GraphExecutor executor;
  Terrain terrain;
  TerrainShadowMap terrain_shadow_map;
  TerrainShadowPass terrain_shadow;
  NightSky night_sky;
  std::unique_ptr<AtmosphereTables> atmosphere;
  std::unique_ptr<AtmosphereTables> next_atmosphere;  ///< being computed, see Renderer::set_atmosphere
  std::unique_ptr<CloudParts> clouds;
  std::unique_ptr<ReferenceTracer> reference;  ///< of quality reference
  AirVolume air_volume;
  BackgroundPass background;
  CompositePass composite;
  ShaftPass shafts;
  ExposurePasses exposure;
  SkyBodies sky;
  FrameLight light;
  double time_s = 0.0;
  CameraPose pose;
  bool told_of_lift = false;  ///< one warning for all pictures
};

/// The sky views of a frame, one per light; none high up.
std::vector<shared::SkyView> sky_views_of(const shared::AtmosphereUniform& air, const shared::FrameConstants& frame);

}  // namespace nepho
