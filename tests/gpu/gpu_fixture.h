#pragma once
#include <doctest/doctest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "base/error.h"
#include "gpu/device.h"
#include "gpu/graph_executor.h"

namespace nepho {

/// A device with validation (and synchronisation validation) for GPU tests. One per process: starting it costs time.
/// The destructor of each fixture fails the test on any message of the validation layer. On a machine without the layer
/// NEPHO_TEST_NO_VALIDATION=1 lets the tests go on; where the layer is, it is used all the same.
class GpuFixture {
 public:
  GpuFixture() : device(shared_device()), executor(device) { device.take_validation_messages(); }
  ~GpuFixture() {
    device.wait_idle();
    for (const std::string& message : device.take_validation_messages()) FAIL_CHECK(message);
  }
  gpu::Device& device;
  gpu::GraphExecutor executor;

 private:
  static gpu::Device& shared_device() {
    static const std::unique_ptr<gpu::Device> instance = make_device();
    return *instance;
  }
  static std::unique_ptr<gpu::Device> make_device() {
    try {
      return std::make_unique<gpu::Device>(gpu::DeviceOptions{.validation = true});
    } catch (const Error&) {
      const char* without = std::getenv("NEPHO_TEST_NO_VALIDATION");
      if (!without || std::string(without) != "1") throw;
      auto device = std::make_unique<gpu::Device>(gpu::DeviceOptions{});
      MESSAGE("validation layer absent");
      return device;
    }
  }
};

}  // namespace nepho
