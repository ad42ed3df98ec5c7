#include "base/patient_caller.h"

#include <doctest/doctest.h>

#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

using namespace nepho;

TEST_CASE("a patient call hands back what the work returns or throws, with and without a limit") {
  for (const double patience_s : {0.0, 30.0}) {
    const PatientCaller caller(patience_s);
    CHECK(caller.call([] { return std::string("done"); }) == "done");
    CHECK_THROWS_WITH(caller.call([]() -> int { throw std::runtime_error("broken"); }), "broken");
    double waited_s = 0.0;
    caller.call(
        [] {
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
          return 0;
        },
        &waited_s);
    CHECK(waited_s >= 0.04);
    CHECK_FALSE(caller.given_up());
  }
}

TEST_CASE("a call that does not come back is given up, and none is made after it") {
  struct Gate {
    std::mutex mutex;
    std::condition_variable changed;
    bool open = false;
  };
  const auto gate = std::make_shared<Gate>();
  const PatientCaller caller(0.1), other(30.0);
  const auto wait_at = [gate] {
    std::unique_lock lock(gate->mutex);
    gate->changed.wait(lock, [&] { return gate->open; });
    return 1;
  };
  CHECK_FALSE(caller.call(wait_at).has_value());
  CHECK(caller.given_up());
  CHECK(calls_left_behind());
  bool called = false;
  CHECK_FALSE(caller
                  .call([&called] {
                    called = true;
                    return 1;
                  })
                  .has_value());
  CHECK_FALSE(called);
  CHECK(other.call([] { return 2; }) == 2);
  {
    const std::lock_guard lock(gate->mutex);
    gate->open = true;
  }
  gate->changed.notify_all();
  while (calls_left_behind()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

TEST_CASE("a call that waits for another one at work on the same source is not given up") {
  const PatientCaller caller(0.3);
  std::mutex source;
  std::thread busy([&] {
    caller.call([&] {
      const std::lock_guard lock(source);
      const auto start = std::chrono::steady_clock::now();
      while (std::chrono::steady_clock::now() - start < std::chrono::milliseconds(900)) {
      }
      return 0;
    });
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK(caller.call([&] {
    const std::lock_guard lock(source);
    return 3;
  }) == 3);
  busy.join();
}
