#include "base/patient_caller.h"

#include <pthread.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace nepho {

namespace {

int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

int64_t processor_ns(clockid_t clock) {
  timespec t{};
  return clock_gettime(clock, &t) == 0 ? int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec : 0;
}

/// One call on its way.
struct Call {
  std::function<void()> work;
  std::mutex mutex;
  std::condition_variable changed;
  bool begun = false, done = false, left_behind = false;
  clockid_t clock{};  // of the thread that works on it, once begun
  int64_t processor_from_ns = 0, processor_to_ns = 0;
};

std::atomic<int> left_behind{0};

/// Threads that wait for calls; as many as were ever needed at once. They are never joined and live as long as the
/// program, which is why this object is never destroyed.
class Threads {
 public:
  /// Those that are as nice as the calling thread: what gives way does so here too. (On Linux each thread has a
  /// niceness of its own, which those that it starts inherit.)
  static Threads& as_nice_as_caller() {
    static auto* const threads = new std::array<Threads, 40>;
    return (*threads)[static_cast<size_t>(std::clamp(getpriority(PRIO_PROCESS, 0) + 20, 0, 39))];
  }
  void begin(std::shared_ptr<Call> call) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(call));
      if (idle_ >= waiting_.size()) {
        changed_.notify_one();
        return;
      }
    }
    std::thread([this] { serve(); }).detach();
  }

 private:
  [[noreturn]] void serve() {
    clockid_t clock{};
    pthread_getcpuclockid(pthread_self(), &clock);
    for (;;) {
      std::shared_ptr<Call> call;
      {
        std::unique_lock lock(mutex_);
        ++idle_;
        changed_.wait(lock, [this] { return !waiting_.empty(); });
        --idle_;
        call = std::move(waiting_.front());
        waiting_.pop_front();
      }
      {
        const std::lock_guard lock(call->mutex);
        call->clock = clock;
        call->processor_from_ns = processor_ns(clock);
        call->begun = true;
      }
      call->work();
      call->work = nullptr;
      const std::lock_guard lock(call->mutex);
      call->processor_to_ns = processor_ns(clock);
      call->done = true;
      if (call->left_behind) --left_behind;
      call->changed.notify_all();
    }
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Call>> waiting_;
  size_t idle_ = 0;
};

}  // namespace

bool PatientCaller::run(std::function<void()> work, double* waited_s) const {
  if (waited_s) *waited_s = 0.0;
  if (patience_s_ <= 0.0) {
    const int64_t start = now_ns(), used = processor_ns(CLOCK_THREAD_CPUTIME_ID);
    work();
    if (waited_s)
      *waited_s = 1e-9 * static_cast<double>(now_ns() - start - (processor_ns(CLOCK_THREAD_CPUTIME_ID) - used));
    return true;
  }
  if (given_up_) return false;
  const auto call = std::make_shared<Call>();
  call->work = std::move(work);
  const int64_t start = now_ns();
  Threads::as_nice_as_caller().begin(call);

  const auto patience_ns = static_cast<int64_t>(patience_s_ * 1e9);
  const auto slice = std::chrono::nanoseconds(std::clamp<int64_t>(patience_ns / 8, 1'000'000, 1'000'000'000));
  int64_t own_sign_ns = start, checked_ns = start, used_ns = 0;
  std::unique_lock lock(call->mutex);
  while (!call->changed.wait_for(lock, slice, [&] { return call->done; })) {
    const int64_t now = now_ns();
    const int64_t used = call->begun ? processor_ns(call->clock) - call->processor_from_ns : 0;
    if (used - used_ns > (now - checked_ns) / 100) {
      own_sign_ns = now;
      last_sign_ns_ = now;
    }
    checked_ns = now;
    used_ns = used;
    // A call may wait for another one that is at work on the same source.
    if (given_up_ || now - std::max(own_sign_ns, last_sign_ns_.load()) > patience_ns) {
      given_up_ = true;
      call->left_behind = true;
      ++left_behind;
      if (waited_s) *waited_s = 1e-9 * static_cast<double>(now - start - used);
      return false;
    }
  }
  const int64_t now = now_ns();
  last_sign_ns_ = now;
  if (waited_s) *waited_s = 1e-9 * static_cast<double>(now - start - (call->processor_to_ns - call->processor_from_ns));
  return true;
}

bool calls_left_behind() { return left_behind > 0; }

}  // namespace nepho
