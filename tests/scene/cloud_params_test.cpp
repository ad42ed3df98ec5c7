#include "scene/cloud_params.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.h"
#include "scene/scene_json.h"
#include "scene/scene_validate.h"

using namespace nepho;

namespace {

/// The message of the input error that these clouds in a scene file s.json end with, without the file's name.
std::string clouds_fail(const std::string& clouds) {
  try {
    scene_from_json(R"({"clouds": )" + clouds + "}", "s.json");
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    const std::string message = e.what();
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message.starts_with("s.json: "));
    return message.substr(std::string("s.json: ").size());
  }
  return "(no error)";
}

CloudParams clouds_of(const std::string& clouds) {
  return scene_from_json(R"({"clouds": )" + clouds + "}", "s.json").clouds;
}

/// The message of the error that validate() ends with, empty without one.
std::string invalid(const Scene& scene) {
  try {
    validate(scene, ErrorKind::usage);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

double top_m(const CloudLayer& layer) { return layer.base_m + layer.thickness_m; }

/// Optical depth of a column through the densest of a layer: its profile integrated by the midpoint rule.
double full_optical_depth(const CloudLayer& layer, const CloudParams& clouds) {
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const DensityProfile& p = layer.density_profile;
    const double eta = (i + 0.5) / 1000.0;
    sum += std::max(p.exp_term * std::exp(p.exponent * eta) + p.linear_term * eta + p.constant_term, 0.0);
  }
  return sum / 1000.0 * layer.thickness_m * layer.density_scale * (clouds.scattering_per_m + clouds.absorption_per_m);
}

}  // namespace

TEST_CASE("every genus and every sky of the lists is known and valid, other names are not") {
  for (const std::string& name : cloud_sky_names()) {
    CAPTURE(name);
    Scene scene;
    REQUIRE(cloud_sky(name).has_value());
    scene.clouds = *cloud_sky(name);
    CHECK(invalid(scene) == "");
  }
  std::set<std::string> names;
  for (const std::string& name : cloud_sky_names()) names.insert(name);
  CHECK(names.size() == cloud_sky_names().size());
  for (const std::string& name : cloud_genus_names()) {
    CAPTURE(name);
    REQUIRE(cloud_genus(name).has_value());
    const CloudParams alone = cloud_sky(name).value();
    CHECK(alone.layers == std::vector<CloudLayer>{*cloud_genus(name)});
    REQUIRE(alone.coverage.has_value());
    CHECK(*alone.coverage > 0.0);
  }
  for (const char* name : {"", "Cumulus", "fair", "nimbostratus"}) CHECK_FALSE(cloud_genus(name).has_value());
  for (const char* name : {"", "stormy"}) CHECK_FALSE(cloud_sky(name).has_value());
}

TEST_CASE("a scene has the sky earth; clear has no layers and no coverage") {
  CHECK(Scene{}.clouds == cloud_sky("earth"));
  CHECK_FALSE(cloud_sky("earth")->coverage.has_value());
  CHECK(cloud_sky("earth")->weather == WeatherParams{});
  CHECK(cloud_sky("clear")->layers.empty());
  CHECK(cloud_sky("clear")->coverage == 0.0);
}

TEST_CASE("genera lie in the heights of the WMO's etages of middle latitudes") {
  for (const char* low : {"stratus", "stratocumulus", "cumulus", "cumulonimbus", "fog"}) {
    CAPTURE(low);
    CHECK(cloud_genus(low)->base_m <= 2000.0);
    CHECK(cloud_genus(low)->base_reference == "terrain");
  }
  CHECK(cloud_genus("altocumulus")->base_m >= 2000.0);
  CHECK(top_m(*cloud_genus("altocumulus")) <= 7000.0);
  CHECK(cloud_genus("cirrus")->base_m >= 5000.0);
  CHECK(top_m(*cloud_genus("cirrus")) <= 13000.0);
  CHECK(top_m(*cloud_genus("cumulonimbus")) > 10000.0);
  CHECK(cloud_genus("fog")->base_m == 0.0);
}

TEST_CASE("full columns of stratus are opaque, those of cirrus are thin but count as cover") {
  const CloudParams clouds;
  CHECK(full_optical_depth(*cloud_genus("stratus"), clouds) > 10.0);
  CHECK(full_optical_depth(*cloud_genus("cumulus"), clouds) > 10.0);
  const CloudLayer cirrus = *cloud_genus("cirrus");
  CHECK(full_optical_depth(cirrus, clouds) == doctest::Approx(8e-4 * cirrus.thickness_m));
  CHECK(full_optical_depth(cirrus, clouds) < 3.0);
  CHECK(full_optical_depth(cirrus, clouds) > cirrus.cover_optical_depth);
}

TEST_CASE("clouds start from the preset of the group, a layer from that of its genus, whatever the order of the keys") {
  CloudParams fair = cloud_sky("fair").value();
  CHECK(clouds_of(R"({"preset": "fair"})") == fair);
  fair.coverage = 0.5;
  CHECK(clouds_of(R"({"coverage": 0.5, "preset": "fair"})") == fair);
  CHECK(clouds_of(R"({"coverage": 0.5})").layers == Scene{}.clouds.layers);

  const CloudParams two = clouds_of(R"({"preset": "fair", "layers": [{"base_m": 900, "genus": "stratus"}, {}]})");
  CloudLayer stratus = cloud_genus("stratus").value();
  stratus.base_m = 900.0;
  CHECK(two.layers == std::vector<CloudLayer>{stratus, CloudLayer{}});
  CHECK(two.coverage == cloud_sky("fair")->coverage);

  const CloudParams profile = clouds_of(R"({"layers": [{"genus": "fog", "density_profile": {"constant_term": 0.9}}]})");
  CHECK(profile.layers[0].density_profile.constant_term == 0.9);
  CHECK(profile.layers[0].density_profile.linear_term == cloud_genus("fog")->density_profile.linear_term);
}

TEST_CASE("a scene of every sky comes back equal from its JSON, which has the values and no names of presets") {
  for (const std::string& name : cloud_sky_names()) {
    Scene scene;
    scene.clouds = cloud_sky(name).value();
    const std::string text = scene_to_json(scene);
    CHECK(text.find("\"preset\"") == std::string::npos);
    CHECK(text.find("\"genus\"") == std::string::npos);
    CHECK_MESSAGE(scene_from_json(text, "s.json") == scene, name);
  }
}

TEST_CASE("an unknown sky, genus or choice is an error with the known ones") {
  CHECK(clouds_fail(R"({"preset": "stormy"})") ==
        "clouds.preset: 'stormy' is not one of earth, clear, fair, broken, overcast, storm, high-cirrus, valley-fog, "
        "stratus, stratocumulus, cumulus, altocumulus, cirrus, cumulonimbus, fog; did you mean 'storm'?");
  CHECK(clouds_fail(R"({"layers": [{}, {"genus": "cumulos"}]})") ==
        "clouds.layers[1].genus: 'cumulos' is not one of stratus, stratocumulus, cumulus, altocumulus, cirrus, "
        "cumulonimbus, fog; did you mean 'cumulus'?");
  CHECK(clouds_fail(R"({"layers": [{"genus": null}]})") == "clouds.layers[0].genus: expected a string, found null");
  CHECK(clouds_fail(R"({"layers": [{"weather_channel": "low"}]})") ==
        "clouds.layers[0].weather_channel: 'low' is not one of r, g, b, a");
  CHECK(clouds_fail(R"({"layers": [{"base_reference": "geoid"}]})")
            .starts_with("clouds.layers[0].base_reference: 'geoid' is not one of ellipsoid, msl, terrain"));
  CHECK(clouds_fail(R"({"weather": {"source": "rastr"}})") ==
        "clouds.weather.source: 'rastr' is not one of procedural, raster, tile; did you mean 'raster'?");
}

TEST_CASE("layers that cannot be are errors that name layer, value and range") {
  CHECK(clouds_fail(R"({"layers": [{}, {}, {}, {}, {}]})") == "clouds.layers: 5 items found; 4 at most");
  CHECK(clouds_fail(R"({"layers": [{}, {"thickness_m": -1}]})") ==
        "clouds.layers[1].thickness_m: -1 is out of range; allowed: 0..100000 m");
  CHECK(clouds_fail(R"({"layers": [{"base_m": 3000, "top_m": 2000}]})")
            .starts_with("unknown key 'clouds.layers[0].top_m'"));
  CHECK(clouds_fail(R"({"layers": [{"thickness_m": NaN}]})").starts_with("line 1, column"));
  CHECK(clouds_fail(R"({"layers": [{"thickness_m": "1 km"}]})") ==
        "clouds.layers[0].thickness_m: expected a number, found the string \"1 km\"");
  CHECK(clouds_fail(R"({"layers": [{"wind_north_mps": 151}]})") ==
        "clouds.layers[0].wind_north_mps: 151 is out of range; allowed: -150..150 m/s");
  CHECK(clouds_fail(R"({"layers": [{"density_scale": -0.1}]})").starts_with("clouds.layers[0].density_scale: -0.1 is"));
  CHECK(clouds_fail(R"({"noise": {"shape": {"period_m": 0}}})") ==
        "clouds.noise.shape.period_m: 0 is out of range; allowed: 1..1000000 m");
  CHECK(clouds_fail(R"({"noise": {"detail": {"velocity_mps": [0, 0, 200]}}})") ==
        "clouds.noise.detail.velocity_mps[2]: 200 is out of range; allowed: -150..150 m/s");
  CHECK(clouds_fail(R"({"weather": {"seed": -1}})") ==
        "clouds.weather.seed: -1 is out of range; allowed: 0..4294967295");
  CHECK(clouds_fail(R"({"phase": "rayleigh"})") ==
        "clouds.phase: 'rayleigh' is not one of dual_hg, cornette_shanks, mie");
  CHECK(clouds_fail(R"({"droplet_diameter_um": 4.9})") ==
        "clouds.droplet_diameter_um: 4.9 is out of range; allowed: 5..50 um");
  CHECK(clouds_fail(R"({"powder": 1.5})") == "clouds.powder: 1.5 is out of range; allowed: 0..1");
  CHECK(clouds_fail(R"({"multiple_scattering_weight": -1})") ==
        "clouds.multiple_scattering_weight: -1 is out of range; allowed: 0..4");
  CHECK(clouds_fail(R"({"sun_taps": "broad"})") == "clouds.sun_taps: 'broad' is not one of near, cone");
  CHECK(clouds_fail(R"({"coverage": -0.01})") == "clouds.coverage: -0.01 is out of range; allowed: 0..1");
}

TEST_CASE("not-a-number and infinity are refused in every number of a layer") {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (double CloudLayer::*member : {&CloudLayer::coverage_scale,
                                       &CloudLayer::base_m,
                                       &CloudLayer::thickness_m,
                                       &CloudLayer::density_scale,
                                       &CloudLayer::shape_amount,
                                       &CloudLayer::detail_amount,
                                       &CloudLayer::weather_exponent,
                                       &CloudLayer::shape_altering_bias,
                                       &CloudLayer::coverage_filter_width,
                                       &CloudLayer::top_relief,
                                       &CloudLayer::anvil_amount,
                                       &CloudLayer::cell_size_m,
                                       &CloudLayer::cell_roundness,
                                       &CloudLayer::stretch,
                                       &CloudLayer::cover_optical_depth,
                                       &CloudLayer::wind_east_mps,
                                       &CloudLayer::wind_north_mps,
                                       &CloudLayer::shear_east_mps_per_km,
                                       &CloudLayer::shear_north_mps_per_km,
                                       &CloudLayer::evolution_speed}) {
      Scene scene;
      scene.clouds.layers.at(1).*member = bad;
      CHECK(invalid(scene).find("is out of range; allowed: ") != std::string::npos);
    }
    Scene scene;
    scene.clouds.layers[0].density_profile.exponent = bad;
    CHECK(invalid(scene).starts_with("clouds.layers[0].density_profile.exponent: "));
    scene = {};
    scene.clouds.noise.turbulence.offset.y = bad;
    CHECK(invalid(scene).starts_with("clouds.noise.turbulence.offset[1]: "));
    scene = {};
    scene.clouds.coverage = bad;
    CHECK(invalid(scene).starts_with("clouds.coverage: "));
  }
}

TEST_CASE("a density profile that is nowhere above 0 is an error, unless the layer is left out by its density") {
  const auto with = [](const DensityProfile& profile) {
    Scene scene;
    scene.clouds.layers.at(1).density_profile = profile;
    return scene;
  };
  const std::string says = "clouds.layers[1].density_profile: nowhere above 0 from base to top";
  CHECK(invalid(with({0.0, 0.0, 0.0, 0.0})).starts_with(says));
  CHECK(invalid(with({0.0, 0.0, -0.5, 0.0})).starts_with(says));
  CHECK(invalid(with({-1.0, 2.0, 0.0, 1.0})).starts_with(says));
  CHECK(invalid(with({0.0, 0.0, 1.0, -1.0})).starts_with(says));
  CHECK(invalid(with({0.0, 0.0, 0.0, 1e-6})) == "");
  CHECK(invalid(with({0.0, 0.0, 1.0, -0.999})) == "");
  // -0.1 exp(4 eta) + 2 eta - 0.4: -0.5 at the base, -3.9 at the top, 0.3 between where 0.4 exp(4 eta) = 2.
  CHECK(invalid(with({-0.1, 4.0, 2.0, -0.4})).starts_with(says));
  CHECK(invalid(with({-0.1, 4.0, 2.0, -0.3})) == "");
  Scene left_out = with({0.0, 0.0, 0.0, 0.0});
  left_out.clouds.layers[1].density_scale = 0.0;
  CHECK(invalid(left_out) == "");
}

TEST_CASE("source and file of the weather must fit") {
  CHECK(clouds_fail(R"({"weather": {"source": "raster"}})") ==
        "clouds.weather.file: is empty; source raster needs a file");
  CHECK(clouds_fail(R"({"weather": {"source": "tile"}})") == "clouds.weather.file: is empty; source tile needs a file");
  CHECK(
      clouds_fail(R"({"weather": {"file": "a.tif"}})") ==
      "clouds.weather.file: 'a.tif' is not looked at by source procedural; give source raster for a map of the globe, "
      "tile for a texture that repeats");
  CHECK(clouds_of(R"({"weather": {"file": "a.tif", "source": "tile"}})").weather.file == "a.tif");
}
