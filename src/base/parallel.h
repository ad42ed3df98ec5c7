#pragma once
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace nepho {

/// While it lives, parallel_for() of this thread keeps to this thread: for work in the background, which shall leave
/// the other cores to what somebody waits for.
class OneCore {
 public:
  OneCore() : before_(active()) { active() = true; }
  ~OneCore() { active() = before_; }
  OneCore(const OneCore&) = delete;
  OneCore& operator=(const OneCore&) = delete;
  static bool& active() {
    static thread_local bool on = false;
    return on;
  }

 private:
  bool before_;
};

/// Calls fn(i) for i in 0..count-1 on all cores, in any order; returns when all are done. Rethrows the first exception.
template <typename F>
void parallel_for(size_t count, F&& fn) {
  const size_t threads = std::min<size_t>({count, std::max(1u, std::thread::hardware_concurrency()), 16});
  if (threads <= 1 || OneCore::active()) {
    for (size_t i = 0; i < count; ++i) fn(i);
    return;
  }
  std::atomic<size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto work = [&] {
    for (size_t i = next++; i < count; i = next++) {
      try {
        fn(i);
      } catch (...) {
        const std::lock_guard lock(error_mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> others;
  for (size_t t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace nepho
