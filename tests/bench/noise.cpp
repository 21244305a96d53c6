#include "tests/bench/noise.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

namespace terravox::bench {
namespace {

/// CPU time of all processors spent on anything, time stolen by other virtual machines too;
/// negative when it cannot be read.
double busy_s() {
    std::ifstream file("/proc/stat");
    std::string label;
    double user = 0;
    double nice = 0;
    double system = 0;
    double idle = 0;
    double wait = 0;
    double interrupt = 0;
    double soft_interrupt = 0;
    double steal = 0;
    if (!(file >> label >> user >> nice >> system >> idle >> wait >> interrupt >> soft_interrupt >>
          steal) ||
        label != "cpu")
        return -1;
    return (user + nice + system + interrupt + soft_interrupt + steal) /
           static_cast<double>(::sysconf(_SC_CLK_TCK));
}

}  // namespace

NoiseMeter::NoiseMeter(const ChildRunner& children)
    : m_children(children),
      m_start(std::chrono::steady_clock::now()),
      m_busy_s(busy_s()),
      m_own_s(own_s()) {}

double NoiseMeter::own_s() const {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime) + m_children.cpu_s();
}

double NoiseMeter::others_cores() const {
    const double busy = busy_s();
    const double wall =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    if (m_busy_s < 0 || busy < 0 || !(wall > 0))
        return -1;
    // The kernel counts in hundredths of a second: over a short time the difference can fall below
    // nothing.
    return std::max(0.0, (busy - m_busy_s - (own_s() - m_own_s)) / wall);
}

}  // namespace terravox::bench
