#include "common/geo/whole_grid.hpp"

#include <fstream>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::geo {
namespace {

// As isspace() of the C locale, without its call for each byte.
bool is_space(char c) noexcept {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

std::optional<std::string> find_lost_values_of_grid(const std::filesystem::path& file,
                                                    std::uint64_t values) {
    constexpr std::size_t kBlock_bytes = std::size_t{1} << 20;
    std::ifstream in(file, std::ios::binary);
    std::vector<char> block(kBlock_bytes);
    std::uint64_t words = 0;
    bool is_in_word = false;
    while (in && words < values) {
        in.read(block.data(), static_cast<std::streamsize>(block.size()));
        for (std::streamsize i = 0; i < in.gcount(); ++i) {
            const bool is_word = !is_space(block[static_cast<std::size_t>(i)]);
            words += is_word && !is_in_word ? 1U : 0U;
            is_in_word = is_word;
        }
    }
    if (words >= values)
        return std::nullopt;
    if (!in.eof())
        throw util::Error("read " + file.string() + " to its end: it cannot be read");
    return "it has fewer than the " + std::to_string(values) + " values that its header states";
}

}  // namespace terravox::geo
