// `nepho probe slab`: columns and refusals. What slabs send is tested in tests/clouds and tests/render.
#include <doctest/doctest.h>

#include <sstream>

#include "base/error.h"
#include "base/files.h"
#include "oracles/oracle_path.h"
#include "probe.h"

using namespace nepho;

namespace {

std::string probe(const std::string& table) {
  std::istringstream in(table);
  std::ostringstream out;
  CHECK(run_probe("slab", in, out) == 0);
  return out.str();
}

std::string refusal(const std::string& table) {
  std::istringstream in(table);
  std::ostringstream out;
  try {
    run_probe("slab", in, out);
  } catch (const Error& e) {
    CHECK(e.kind() == ErrorKind::input);
    CHECK(out.str().empty());
    return e.what();
  }
  FAIL("no error from: " << table);
  return "";
}

}  // namespace

TEST_CASE("probe slab writes the columns of the oracle, in their order") {
  const std::string oracle = read_text_file(test::oracle_path("slab_dev.csv"));
  CHECK(probe("tau,omega0,g,mu0\n") == oracle.substr(0, oracle.find('\n') + 1));
}

TEST_CASE("probe slab refuses layers that cannot be, naming line and column") {
  const auto names = [](const std::string& row, const char* column) {
    const std::string message = refusal("tau,omega0,g,mu0\n1,1,0.5,0.5\n" + row + "\n");
    CAPTURE(message);
    CHECK(message.find("line 3") != std::string::npos);
    CHECK(message.find(column) != std::string::npos);
  };
  names("0,1,0,1", "tau");
  names("-1,1,0,1", "tau");
  names("1001,1,0,1", "tau");
  names("1,1.01,0,1", "omega0");
  names("1,-0.1,0,1", "omega0");
  names("1,1,1,1", "g");
  names("1,1,-1,1", "g");
  names("1,1,0,0", "mu0");
  names("1,1,0,1.001", "mu0");
  names("1,1,0,x", "mu0");
  CHECK(refusal("tau,omega0,g\n1,1,0\n").find("mu0") != std::string::npos);
}
