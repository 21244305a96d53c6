#include "raytracer/core/scene/names.hpp"

#include <algorithm>
#include <utility>

#include "common/util/near_words.hpp"

namespace terravox::scene {
namespace {

// U+00C0 to U+017F: Latin-1 has its small letters 32 later, Latin Extended-A one later, where
// capitals are even or odd by stretches.
unsigned small_letter(unsigned c) {
    if (c >= 0xC0 && c <= 0xDE && c != 0xD7)
        return c + 32;
    const bool even_capitals = (c >= 0x100 && c <= 0x137) || (c >= 0x14A && c <= 0x177);
    const bool odd_capitals = (c >= 0x139 && c <= 0x148) || (c >= 0x179 && c <= 0x17E);
    if ((even_capitals && c % 2 == 0) || (odd_capitals && c % 2 == 1))
        return c + 1;
    return c;
}

}  // namespace

std::string folded(const std::string& name) {
    std::string out;
    bool apart = false;
    const auto add = [&](char c) {
        if (apart && !out.empty())
            out += ' ';
        apart = false;
        out += c;
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto byte = static_cast<unsigned char>(name[i]);
        if (byte == ' ' || byte == '-' || byte == '_' || byte == '\t')
            apart = true;
        else if (byte >= 'A' && byte <= 'Z')
            add(static_cast<char>(byte - 'A' + 'a'));
        else if (byte >= 0xC3 && byte <= 0xC5 && i + 1 < name.size() &&
                 (static_cast<unsigned char>(name[i + 1]) & 0xC0) == 0x80) {
            const unsigned letter =
                small_letter((byte & 0x1FU) << 6 | (static_cast<unsigned char>(name[++i]) & 0x3FU));
            add(static_cast<char>(0xC0 | letter >> 6));
            add(static_cast<char>(0x80 | (letter & 0x3F)));
        } else
            add(name[i]);
    }
    return out;
}

std::vector<std::string> near_names(const std::string& asked, const std::vector<std::string>& names,
                                    std::size_t max) {
    constexpr std::size_t kLongest = 200;  // longer than any name: not worth the time
    const std::string wanted = folded(asked);
    std::vector<std::pair<std::size_t, std::string>> near;
    if (wanted.empty() || wanted.size() > kLongest)
        return {};
    for (const std::string& name : names) {
        const std::string known = folded(name);
        const std::size_t distance = util::edit_distance(wanted, known);
        const bool holds =
            wanted.size() >= 3 && known.size() >= 3 &&
            (known.find(wanted) != std::string::npos || wanted.find(known) != std::string::npos);
        if (holds || distance <= std::max<std::size_t>(2, known.size() / 3))
            near.emplace_back(distance, name);
    }
    std::sort(near.begin(), near.end());
    std::vector<std::string> out;
    for (std::size_t i = 0; i < std::min(max, near.size()); ++i)
        out.push_back(near[i].second);
    return out;
}

}  // namespace terravox::scene
