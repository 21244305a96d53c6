#include "voxelserver/make/worlds/minecraft/blocks/block_pattern.hpp"

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::size_t kMaxNames = 4096;  // of one pattern

/// `fail` must throw; if it does not, this does, so that no partial pattern is used.
[[noreturn]] void stop(const Fail& fail, const std::string& what) {
    fail(what);
    throw util::Error(what);
}

std::vector<std::string_view> split(std::string_view text, char at) {
    std::vector<std::string_view> out;
    for (;;) {
        const auto end = text.find(at);
        out.push_back(text.substr(0, end));
        if (end == std::string_view::npos)
            return out;
        text.remove_prefix(end + 1);
    }
}

/// Replaces each name by copies with each of `count` texts appended.
template <class Append>
void branch(std::vector<Expanded>& names, std::size_t count, const Append& append,
            std::string_view pattern, const Fail& fail) {
    if (names.size() * count > kMaxNames)
        stop(fail, "'" + std::string(pattern) + "' stands for more than " +
                       std::to_string(kMaxNames) + " names");
    std::vector<Expanded> out;
    out.reserve(names.size() * count);
    for (const Expanded& name : names)
        for (std::size_t i = 0; i < count; ++i)
            append(out.emplace_back(name), i);
    names = std::move(out);
}

}  // namespace

bool Condition::holds(Properties properties) const noexcept {
    for (const Property& p : properties)
        if (p.name == property)
            return std::find(values.begin(), values.end(), p.value) != values.end();
    return false;
}

BlockState block_state_from(std::string_view text, const Fail& fail) {
    BlockState out;
    const auto open = text.find('[');
    out.name = text.substr(0, open);
    if (out.name.empty() || out.name.find(']') != std::string::npos)
        stop(fail,
             "'" + std::string(text) + "' names no block; allowed: name or name[property=value]");
    if (open == std::string_view::npos)
        return out;
    if (text.back() != ']')
        stop(fail, "'" + std::string(text) + "' lacks its last ']'");
    for (const std::string_view part : split(text.substr(open + 1, text.size() - open - 2), ',')) {
        const auto equal = part.find('=');
        if (equal == 0 || equal == std::string_view::npos)
            stop(fail, "'" + std::string(text) + "': '" + std::string(part) +
                           "' is no condition; allowed: property=value");
        Condition& condition = out.conditions.emplace_back();
        condition.property = part.substr(0, equal);
        for (const std::string_view value : split(part.substr(equal + 1), '|'))
            condition.values.emplace_back(value);
    }
    return out;
}

std::vector<Expanded> expand(std::string_view pattern, const Words& words, const Fail& fail) {
    std::vector<Expanded> out(1);
    for (std::size_t i = 0; i < pattern.size();) {
        const char c = pattern[i];
        if (c == '}' || c == ')')
            stop(fail, "'" + std::string(pattern) + "' closes what it does not open");
        if (c != '{' && c != '(') {
            for (Expanded& name : out)
                name.name += c;
            ++i;
            continue;
        }
        const auto end = pattern.find(c == '{' ? '}' : ')', i);
        if (end == std::string_view::npos)
            stop(fail, "'" + std::string(pattern) + "' does not close its " + c);
        const std::string_view inside = pattern.substr(i + 1, end - i - 1);
        if (c == '{') {
            const auto list = words.find(inside);
            if (list == words.end())
                stop(fail, "'" + std::string(pattern) + "': {" + std::string(inside) +
                               "} is none of [words]");
            branch(
                out, list->second.size(),
                [&](Expanded& name, std::size_t k) {
                    name.name += list->second[k].text;
                    name.chosen[list->first] = &list->second[k];
                },
                pattern, fail);
        } else {
            if (inside.find('(') != std::string_view::npos)
                stop(fail, "'" + std::string(pattern) + "' has ( inside of ()");
            std::vector<Expanded> texts;
            for (const std::string_view text : split(inside, '|'))
                for (Expanded& one : expand(text, words, fail))
                    texts.push_back(std::move(one));
            branch(
                out, texts.size(),
                [&](Expanded& name, std::size_t k) {
                    name.name += texts[k].name;
                    name.chosen.insert(texts[k].chosen.begin(), texts[k].chosen.end());
                },
                pattern, fail);
        }
        i = end + 1;
    }
    return out;
}

std::size_t own_letters(std::string_view pattern) noexcept {
    std::size_t n = 0;
    bool inside = false;
    for (const char c : pattern) {
        if (c == '{' || c == '(')
            inside = true;
        else if (c == '}' || c == ')')
            inside = false;
        else
            n += !inside && c != '*';
    }
    return n;
}

bool fits(std::string_view pattern, std::string_view name) noexcept {
    // Greedy: only the last star needs backtracking.
    std::size_t p = 0;
    std::size_t n = 0;
    std::size_t star = std::string_view::npos;
    std::size_t from = 0;
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            from = n;
        } else if (p < pattern.size() && pattern[p] == name[n]) {
            ++p;
            ++n;
        } else {
            if (star == std::string_view::npos)
                return false;
            p = star + 1;
            n = ++from;
        }
    }
    while (p < pattern.size() && pattern[p] == '*')
        ++p;
    return p == pattern.size();
}

}  // namespace terravox::minecraft
