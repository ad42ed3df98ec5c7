#include "terrain/host_cache.h"

#include <algorithm>
#include <limits>

namespace nepho {

void HostBudget::join(Member& member) {
  const std::lock_guard lock(members_mutex_);
  members_.push_back(&member);
}

void HostBudget::leave(Member& member) {
  const std::lock_guard lock(members_mutex_);
  std::erase(members_, &member);
  bytes_ -= member.drop_until(std::numeric_limits<uint64_t>::max()).first;
}

void HostBudget::add(uint64_t bytes) {
  if (bytes_ + bytes > limit_bytes_) make_room(bytes);
  const uint64_t now = bytes_ += bytes;
  uint64_t peak = peak_bytes_;
  while (now > peak && !peak_bytes_.compare_exchange_weak(peak, now)) {
  }
}

void HostBudget::make_room(uint64_t bytes) {
  const std::lock_guard lock(members_mutex_);
  if (bytes_ + bytes <= limit_bytes_) return;  // somebody else was here first
  std::vector<Member::Use> uses;
  for (const Member* member : members_) member->list(uses);
  std::sort(uses.begin(), uses.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  // An eighth is left free, so that this does not happen with every value.
  const uint64_t wanted = limit_bytes_ / 8 * 7 - std::min(bytes, limit_bytes_ / 8 * 7);
  uint64_t left = 0, until = 0;
  for (const Member::Use& use : uses) left += use.bytes;
  for (const Member::Use& use : uses) {
    if (left <= wanted) break;
    left -= use.bytes;
    until = use.stamp;
  }
  for (Member* member : members_) {
    const auto [freed, count] = member->drop_until(until);
    bytes_ -= freed;
    dropped_ += count;
  }
}

}  // namespace nepho
