// shaders/common/gamut.h
#include "common/gamut.h"

#include <doctest/doctest.h>

#include <initializer_list>

using nepho::shared::within_rec709;

namespace {
float luminance(const glm::vec3& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
}  // namespace

TEST_CASE("colours within Rec. 709 stay as they are, those outside keep their luminance and lose their negative part") {
  for (const glm::vec3 c : {glm::vec3(0.0f), glm::vec3(1.0f, 0.0f, 3.0f), glm::vec3(5.0f, 7.0f, 9.0f)})
    CHECK(within_rec709(c) == c);
  for (const glm::vec3 c :
       {glm::vec3(9.0f, 1.0f, -0.4f), glm::vec3(-2.0f, 3.0f, 8.0f), glm::vec3(1e-6f, -2e-7f, 1e-5f)}) {
    const glm::vec3 inside = within_rec709(c);
    CHECK(inside.x >= 0.0f);
    CHECK(inside.y >= 0.0f);
    CHECK(inside.z >= 0.0f);
    CHECK(luminance(inside) == doctest::Approx(luminance(c)).epsilon(1e-5));
  }
  CHECK(within_rec709(glm::vec3(-1.0f)) == glm::vec3(0.0f));  // less than no light is none
}
