#pragma once

namespace nepho {

/// This thread gives way to the program's others from now on (a niceness of its own, where the system knows such).
void give_way();

}  // namespace nepho
