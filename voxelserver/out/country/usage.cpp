#include "voxelserver/out/country/usage.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <array>

namespace terravox::country {
namespace {

struct rusage used() {
    struct rusage out{};
    ::getrusage(RUSAGE_SELF, &out);
    return out;
}

double seconds(const timeval& t) noexcept {
    constexpr double kMicro = 1e-6;
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * kMicro;
}

}  // namespace

double used_cpu_s() {
    const struct rusage now = used();
    return seconds(now.ru_utime) + seconds(now.ru_stime);
}

double used_peak_mib() {
    constexpr double kKibOfMib = 1024;
    return static_cast<double>(used().ru_maxrss) / kKibOfMib;
}

std::string host_name() {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

}  // namespace terravox::country
