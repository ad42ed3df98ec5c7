// The passes of one frame, in order (docs/architecture.md).
#include "render/renderer_parts.h"

namespace nepho {
namespace {

constexpr float kFroxelsBelow_m = 30e3f;  ///< cameras that light shafts by froxels of themselves

ShaftMethod shaft_method_of(const Scene& scene, const FrameInfo& frame) {
  const ShaftMethod method = shaft_method(scene.shafts, scene.render.quality);
  // A frustum grid's cells are too long for the limb.
  if (scene.shafts.method == "auto" && method == ShaftMethod::froxel &&
      frame.constants.planet.camera_height_m > kFroxelsBelow_m)
    return ShaftMethod::shadow_length;
  return method;
}

}  // namespace

FrameOutputs Renderer::Parts::add_frame(FrameGraph& graph, const FrameInfo& frame, const Scene& scene,
                                        const FrameNeeds& needs) {
  FrameOutputs out;
  const std::vector<shared::SkyView> views = sky_views_of(atmosphere->uniform(), frame.constants);
  const AtmosphereTables::Refs tables = atmosphere->add(graph, views);
  const double lit_top_m = clouds ? static_cast<double>(clouds->clouds.constants().hull_high_m) : 0.0;
  // Pictures that are compared with the path tracer have their air integrated; those that follow each other read it.
  const AirVolume::Refs volume =
      (needs.sequence || needs.live) && AirVolume::serves(atmosphere->uniform(), frame.constants, lit_top_m)
          ? air_volume.add(graph, frame, *atmosphere, tables, lit_top_m)
          : AirVolume::Refs{};
  const NightSky::Refs stars = night_sky.add(graph, frame, scene.night_sky, sky);
  const Terrain::Outputs surface = terrain.add(graph, frame);
  BackgroundPass::Inputs behind{.terrain = surface,
                                .atmosphere = tables,
                                .air_volume = volume,
                                .night_sky = stars,
                                .has_sky_view = !views.empty(),
                                .night = NightSky::shows(frame.constants) || frame.constants.light_count > 1,
                                .sun_visibility = {},
                                .wind_mps = static_cast<float>(scene.terrain.water_wind_mps)};
  CloudDensityRefs density;
  CloudShadowRefs shadow;
  CloudLight::Refs cloud_light;
  const bool terrain_shades =
      scene.terrain.shadows && terrain_shadow_map.update(terrain.heights(), frame, needs.incomplete_ground);
  const TerrainVolumeRefs terrain_air =
      terrain_shades ? terrain_shadow_map.add_volume(graph, frame, needs.sequence) : TerrainVolumeRefs{};
  if (clouds) {
    density = import_cloud_density(graph, frame, clouds->clouds);
    CloudLighting& lighting = clouds->lighting(needs.live);
    clouds->ground.update(terrain.heights(), terrain.imagery(), lighting.inside.region(frame),
                          !needs.sequence           ? GroundMap::Follow::exactly
                          : needs.incomplete_ground ? GroundMap::Follow::in_background
                                                    : GroundMap::Follow::near);
    const GroundMap::Refs ground = clouds->ground.import_into(graph);
    cloud_light = lighting.inside.add(graph, frame,
                                    {.depth_m = surface.depth_m,
                                     .density = density,
                                     .atmosphere = &tables,
                                     .terrain_shadow = terrain_air.shadow,
                                     .terrain_map = terrain_air.map,
                                     .ground = clouds->ground.map(),
                                     .ground_albedo = ground.albedo,
                                     .ground_height = ground.height_m,
                                     .sequence = needs.sequence});
    behind.cloud_light = cloud_light.ground;
    shadow = lighting.shadows.add(graph, frame, density);
    behind.sun_visibility = clouds->shadow.add(graph, frame, surface, shadow);
  }
  const ShaftPass::Air air{.atmosphere = tables,
                           .uniform = &atmosphere->uniform(),
                           .shadow = shadow,
                           .terrain = terrain_air,
                           .terrain_top_m = terrain_shades ? terrain_shadow_map.shade_top_m(frame) : 0.0,
                           .cloud_top_m = clouds ? static_cast<double>(clouds->clouds.constants().hull_high_m) : 0.0,
                           .ground_m = terrain.ground_height_m(pose.at.lat_rad, pose.at.lon_rad),
                           .ground_albedo = scene.atmosphere.ground_albedo,
                           .sequence = needs.sequence || needs.live};
  behind.shafts = shafts.add_constants(graph, frame, scene.shafts, scene.haze, air);
  behind.haze_layers = static_cast<uint32_t>(drawn_haze(scene.haze).size());
  if (terrain_shades)
    behind.sun_visibility = terrain_shadow.add(graph, frame, surface, terrain_shadow_map.import_into(graph),
                                               terrain_air.lit, behind.sun_visibility);
  const ImageRef lit = background.add(graph, frame, scene.atmosphere, behind);
  const ShaftMethod method = shaft_method_of(scene, frame);
  CloudMarchPass::Outputs marched;
  CloudUpscaler::Selection selected{.frame = frame};
  const bool upscales = clouds && scene.render.upscale > 1;
  if (upscales)
    selected =
        clouds->upscaler.select(graph, frame, scene.render.upscale, surface.depth_m, method == ShaftMethod::screen);
  if (clouds)
    marched = clouds->march.add(graph, selected.frame,
                                {.depth_m = surface.depth_m,
                                 .atmosphere = tables,
                                 .air_volume = volume,
                                 .density = density,
                                 .light = cloud_light,
                                 .list = selected.list,
                                 .whole_steps = needs.live && (upscales || software),
                                 .radiance = selected.radiance,
                                 .info = selected.info,
                                 .depths = selected.depths});
  const FroxelRefs froxels = method == ShaftMethod::froxel
                                 ? shafts.add_froxels(graph, frame, scene.shafts, scene.haze, method, air, false)
                                 : FroxelRefs{};
  const ShaftPass::Outputs aired = shafts.add(graph, frame, scene.shafts, scene.haze, method, air,
                                              {.depth_m = surface.depth_m,
                                               .background = lit,
                                               .cloud = marched.radiance,
                                               .cloud_near = marched.near,
                                               .cloud_depths = marched.depths,
                                               .froxels = froxels,
                                               .list = selected.list});
  out.depth_m = surface.depth_m;
  out.albedo = surface.albedo;
  out.sun_visibility = behind.sun_visibility;
  out.background = out.radiance = aired.background;
  out.cloud = aired.cloud;
  out.cloud_info = marched.info;
  if (upscales) {
    const CloudUpscaler::Outputs whole = clouds->upscaler.resolve(
        graph, frame, selected, {.depth_m = surface.depth_m, .cloud = out.cloud, .info = marched.info});
    out.cloud = marched.radiance = whole.cloud;
    out.cloud_info = marched.info = whole.info;
  }
  if (clouds) {
    out.radiance = composite.add(graph, frame, out.background, out.cloud);
    if (!needs.debug.empty())
      out.debug = clouds->debug.add(graph, frame, needs.debug, surface.depth_m, density, marched, shadow);
    if (needs.layers)
      out.shadow_layers = clouds->shadow.add_layers(graph, frame,
                                                    {.depth_m = surface.depth_m,
                                                     .visibility = behind.sun_visibility,
                                                     .cloud_radiance = out.cloud,
                                                     .cloud_info = out.cloud_info},
                                                    shadow);
  }
  if (needs.display) out.exposure = exposure.add(graph, out.radiance, scene.render, needs.interval_s);
  out.keep(graph, needs);
  return out;
}

void FrameOutputs::keep(FrameGraph& graph, const FrameNeeds& needs) const {
  const auto keep = [&](auto ref) {
    if (ref) graph.keep(ref);
  };
  keep(radiance);
  keep(debug);
  if (needs.work) keep(cloud_info);
  if (needs.display) {
    keep(exposure.display);
    keep(exposure.state);
  }
  if (!needs.layers) return;
  keep(depth_m);
  keep(albedo);
  keep(background);
  if (cloud_info) {
    keep(cloud);
    keep(cloud_info);
    keep(shadow_layers);
  } else {
    keep(sun_visibility);
  }
}

}  // namespace nepho
