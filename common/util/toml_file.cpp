#include "common/util/toml_file.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"

namespace terravox::util {

namespace fs = std::filesystem;

toml::table read_toml(const fs::path& file, const std::function<void(const std::string&)>& fail) {
    return parse_toml(read_text(file, kMaxToml_bytes, fail), file.string(), fail);
}

toml::table parse_toml(std::string_view text, const std::string& name,
                       const std::function<void(const std::string&)>& fail) {
    if (text.size() > kMaxToml_bytes)
        fail("longer than 1 MiB; allowed: up to 1 MiB");
    // Each dot of a name (a.b.c) makes a nested table, and tables are processed recursively:
    // 100,000 of them overflow a stack of 8 MiB.
    constexpr std::ptrdiff_t kMaxDots = 10'000;
    if (const auto dots = std::count(text.begin(), text.end(), '.'); dots > kMaxDots)
        fail(std::to_string(dots) + " dots; allowed: up to 10000");
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error& e) {
        fail(std::string(e.description()) + " (line " + std::to_string(e.source().begin.line) +
             ")");
    }
    throw Error("read {}: failed", name);  // reached only if `fail` has not thrown
}

void allow_only(const toml::table& table, const std::string& where,
                std::initializer_list<std::string_view> fields,
                const std::function<void(const std::string&)>& fail) {
    for (const auto& [key, node] : table)
        if (std::find(fields.begin(), fields.end(), key.str()) == fields.end())
            fail(fmt::format("{}{} is no field; allowed: {}", where, key.str(),
                             fmt::join(fields, ", ")));
}

fs::path find_toml(const std::string& id_or_path, const char* folder, const char* what) {
    const fs::path path = id_or_path;
    if (path.extension() == ".toml") {
        if (!fs::exists(path))
            throw UsageError("read the {} {}: no such file", what, path.string());
        return path;
    }
    const fs::path shipped = config_dir() / folder;
    const fs::path file = shipped / (id_or_path + ".toml");
    if (id_or_path.empty() || id_or_path.find('/') != std::string::npos || !fs::exists(file))
        throw UsageError("find the {} '{}': allowed: {}, or a path to a .toml file", what,
                         id_or_path, toml_ids(shipped));
    return file;
}

std::string toml_value(const toml::node& node) {
    constexpr std::size_t kMaxBytes = 60;
    if (const auto* text = node.as_string()) {
        const std::string& value = text->get();
        return "'" + (value.size() > kMaxBytes ? value.substr(0, kMaxBytes) + "..." : value) + "'";
    }
    if (const auto* whole = node.as_integer())
        return std::to_string(whole->get());
    if (const auto* number = node.as_floating_point()) {
        const std::string out = number_text(number->get(), 15);
        // 2.0 is not shown as 2, which is another type; "inf" and "nan" stay.
        return out.find_first_of(".en") == std::string::npos ? out + ".0" : out;
    }
    if (const auto* flag = node.as_boolean())
        return flag->get() ? "true" : "false";
    if (node.is_array())
        return "a list";
    return node.is_table() ? "a table" : "a date or time";
}

}  // namespace terravox::util
