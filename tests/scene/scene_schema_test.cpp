#include "scene/scene_schema.h"

#include <doctest/doctest.h>

#include "scene/cloud_params.h"

using namespace nepho;

namespace {
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
}  // namespace

TEST_CASE("vectors say what their components are: wavelengths, directions or axes") {
  const std::string text = parameters_markdown();
  CHECK(has(text,
            "scattering coefficient at height 0; more makes the sky bluer and sunsets redder: at 680, 550, 440 nm |"));
  CHECK(has(text, "\n## clouds.layers[].density_profile\n"));
  CHECK(has(text, "motion relative to the layer's wind: east, north, up |"));
  CHECK(has(text, "shift: along x, y, z of the texture |"));
}

TEST_CASE("the table of parameters has the names of other libraries") {
  const std::string text = parameters_markdown();
  for (const char* name : {"channel",
                           "altitude",
                           "height",
                           "densityScale",
                           "shapeAmount",
                           "shapeDetailAmount",
                           "weatherExponent",
                           "shapeAlteringBias",
                           "coverageFilterWidth",
                           "densityProfile.expTerm",
                           "densityProfile.exponent",
                           "densityProfile.linearTerm",
                           "densityProfile.constantTerm",
                           "shadow",
                           "coverage",
                           "localWeatherVelocity",
                           "localWeatherOffset",
                           "shapeOffset",
                           "shapeVelocity",
                           "shapeDetailOffset",
                           "shapeDetailVelocity",
                           "turbulenceDisplacement",
                           "scatteringCoefficient",
                           "absorptionCoefficient",
                           "skyLightScale",
                           "groundBounceScale",
                           "scatterAnisotropy1",
                           "scatterAnisotropy2",
                           "scatterAnisotropyMix",
                           "stbnTexture"})
    CHECK_MESSAGE(has(text, std::string("| ") + name + " |"), name);
  for (const char* name : {"localWeatherRepeat = ", "shapeRepeat = ", "shapeDetailRepeat = ", "turbulenceRepeat "})
    CHECK_MESSAGE(has(text, std::string("| ") + name), name);
}

TEST_CASE("the schema knows presets and genera, and gives a default only where there is one") {
  const std::string text = scene_schema();
  for (const std::string& name : cloud_sky_names()) CHECK_MESSAGE(has(text, '"' + name + '"'), name);
  const size_t genus = text.find("\"genus\": {");
  REQUIRE(genus != std::string::npos);
  const std::string entry = text.substr(genus, text.find('}', genus) - genus);
  CHECK(has(entry, "\"cumulonimbus\""));
  CHECK_FALSE(has(entry, "default"));
  CHECK(has(text, "\"maxItems\": 4"));
}
