#include "raytracer/apps/commands/arguments/number_list.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "common/util/error.hpp"

namespace terravox::commands {

std::vector<double> numbers_of(const std::string& command, const std::string& flag,
                               const std::string& text, std::size_t count,
                               const std::string& allowed) {
    std::vector<double> out;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) {
        double value = 0;
        const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
        if (read.ec != std::errc{} || read.ptr != word.data() + word.size() ||
            !std::isfinite(value))
            break;
        out.push_back(value);
    }
    if (!text.empty() &&
        (out.size() != count ||
         static_cast<std::size_t>(std::count(text.begin(), text.end(), ',')) + 1 != count))
        throw util::UsageError(command + ": " + flag + " " + text + "; allowed: " + allowed);
    return out;
}

}  // namespace terravox::commands
