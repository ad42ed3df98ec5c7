#include "base/give_way.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace nepho {

void give_way() {
  constexpr int kNiceness = 5;
  // Linux has a niceness per thread. What fails here only costs smoothness.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNiceness);
}

}  // namespace nepho
