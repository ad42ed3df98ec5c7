#pragma once
#include <doctest/doctest.h>

#include <memory>
#include <string>

#include "base/error.h"
#include "gpu/device.h"
#include "gpu/graph_executor.h"

namespace nepho {

/// A device with validation (and synchronisation validation) for GPU tests. One per process: starting it costs time.
/// The destructor of each fixture fails the test on any message of the validation layer.
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
    static gpu::Device instance({.validation = true});
    return instance;
  }
};

}  // namespace nepho
