#include "common/util/cache_dir.hpp"

#include <cstdlib>

namespace terravox::util {

std::filesystem::path cache_dir(const std::string& given) {
    if (given == "none")
        return {};
    if (!given.empty())
        return given;
    const auto variable = [](const char* name) -> std::filesystem::path {
        const char* value = std::getenv(name);
        return value == nullptr ? "" : value;
    };
    // The XDG specification requires relative paths to be ignored.
    if (const auto base = variable("XDG_CACHE_HOME"); base.is_absolute())
        return base / "terravox";
    if (const auto home = variable("HOME"); home.is_absolute())
        return home / ".cache" / "terravox";
    return {};
}

}  // namespace terravox::util
