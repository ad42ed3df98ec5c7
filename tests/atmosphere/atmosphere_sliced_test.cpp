// Tables that are computed a little at a time.
#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <vector>

#include "atmosphere/atmosphere_fixture.h"

using namespace nepho;

namespace {

/// A cache folder of its own while it lives.
class OwnCache {
 public:
  explicit OwnCache(const std::string& name)
      : folder_(std::filesystem::temp_directory_path() / ("nepho_" + name + "_" + std::to_string(::getpid()))) {
    use();
  }
  ~OwnCache() {
    std::filesystem::remove_all(folder_);
    ::setenv("NEPHO_CACHE", NEPHO_TEST_CACHE, 1);
  }
  void use() const { ::setenv("NEPHO_CACHE", folder_.c_str(), 1); }

 private:
  std::filesystem::path folder_;
};

AtmosphereParams two_orders() {
  AtmosphereParams p = AtmosphereParams::earth();
  p.spectral = "fast";
  p.scattering_orders = 2;
  p.ground_albedo = 0.37;  // nobody else's
  return p;
}

std::vector<AtmosphereProbe::Answer> answers_of(AtmosphereFixture& gpu,
                                                std::shared_ptr<const AtmosphereTables> tables) {
  AtmosphereProbe probe(gpu.device, std::move(tables));
  std::vector<shared::AtmosphereCase> cases;
  for (int i = 0; i < 64; ++i) {
    const double h = 2.0 * std::pow(1.4, i), a = 0.37 * i;
    auto c = view_case({6378137.0 + h, 0.0, 0.0}, {std::sin(a), std::cos(a), 0.3}, {std::cos(2.0 * a), 0.5, 0.4}, false,
                       Ellipsoid::wgs84());
    c.distance_m = 30000.0f;
    c.h = static_cast<float>(std::min(h, 99e3));
    c.mu_s = static_cast<float>(std::cos(2.0 * a));
    cases.push_back(c);
  }
  std::vector<AtmosphereProbe::Answer> all;
  for (const uint32_t kind : {shared::kProbeSkyRadiance, shared::kProbeRadianceToPoint, shared::kProbeIrradiance,
                              shared::kProbeSunTransmittance}) {
    const auto some = probe.ask(kind, cases);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

}  // namespace

TEST_CASE("tables computed in slices take many short steps and have the bits of those computed at once") {
  AtmosphereFixture gpu;
  const OwnCache first("at_once");
  const auto at_once = std::make_shared<const AtmosphereTables>(gpu.device, two_orders());
  REQUIRE_FALSE(at_once->came_from_cache());
  CHECK(at_once->ready());
  CHECK(at_once->progress() == 1.0);

  const OwnCache second("sliced");
  const auto sliced = std::make_shared<AtmosphereTables>(gpu.device, two_orders(), AtmosphereTables::Start::sliced);
  REQUIRE_FALSE(sliced->came_from_cache());
  CHECK_FALSE(sliced->ready());
  CHECK(sliced->progress() == 0.0);
  int calls = 0;
  double last = 0.0;
  for (bool done = false; !done && calls < 1000; ++calls) {
    done = sliced->advance(0.0);
    CHECK(done == sliced->ready());
    CHECK(sliced->progress() > last);  // every call does something
    CHECK((sliced->progress() == 1.0) == done);
    last = sliced->progress();
  }
  CHECK(last == 1.0);
  // Transmittance, eight groups of heights of incident light and two sums for each order, sources, the mirrored sky.
  CHECK(calls >= 20);
  CHECK(sliced->advance(0.0));  // and nothing more

  const auto a = answers_of(gpu, at_once), b = answers_of(gpu, sliced);
  size_t different = 0;
  for (size_t i = 0; i < a.size(); ++i) different += static_cast<size_t>(a[i].a != b[i].a || a[i].b != b[i].b);
  CHECK(different == 0);

  // They went to the cache: whoever starts in slices from there is ready.
  const AtmosphereTables again(gpu.device, two_orders(), AtmosphereTables::Start::sliced);
  CHECK(again.came_from_cache());
  CHECK(again.ready());
}
