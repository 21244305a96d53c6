#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace terravox::test {

/// The bytes of a file; none where there is no such file.
inline std::string read_content(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Makes a file of these bytes, and the folders that it lies in.
inline void write_content(const std::filesystem::path& file, const std::string& bytes) {
    if (file.has_parent_path())
        std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
}

/// A text with `what` replaced wherever it stands.
inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
        text.replace(at, what.size(), with);
    return text;
}

}  // namespace terravox::test
