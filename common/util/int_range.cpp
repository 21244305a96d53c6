#include "common/util/int_range.hpp"

#include <charconv>

#include "common/util/error.hpp"

namespace terravox::util {

IntRange parse_range(const std::string& what, const std::string& text, IntRange allowed) {
    IntRange out{-1, -1};
    const char *begin = text.data(), *end = begin + text.size();
    auto read = std::from_chars(begin, end, out.first);
    if (read.ec == std::errc{} && read.ptr == end)
        out.last = out.first;
    else if (read.ec == std::errc{} && *read.ptr == '-') {
        read = std::from_chars(read.ptr + 1, end, out.last);
        if (read.ec != std::errc{} || read.ptr != end)
            out.last = -1;
    }
    if (begin == end || out.first < allowed.first || out.last < out.first ||
        out.last > allowed.last)
        throw UsageError(what + " " + text +
                         "; allowed: one number or two with a dash between, from " +
                         std::to_string(allowed.first) + " to " + std::to_string(allowed.last));
    return out;
}

}  // namespace terravox::util
