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

}  // namespace terravox::test
