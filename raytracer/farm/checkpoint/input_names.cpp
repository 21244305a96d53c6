#include "raytracer/farm/checkpoint/input_names.hpp"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>

#include "common/util/config_dir.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/material/material_file.hpp"

namespace terravox::farm {
namespace {

namespace fs = std::filesystem;

/// Files that a program writes next to its data while they are open, and hidden files.
bool is_passing(const std::string& name) {
    constexpr std::array kEndings = {".lock", "-wal", "-shm", "-journal"};
    return name.starts_with('.') ||
           std::any_of(kEndings.begin(), kEndings.end(),
                       [&](const char* ending) { return name.ends_with(ending); });
}

[[noreturn]] void fail_to_name(const fs::path& file, const std::string& what) {
    throw util::Error("name the inputs of the picture: " + file.string() + ": " + what);
}

class Contents {
public:
    /// @param as the file's name relative to the input
    void add(const fs::path& file, const std::string& as) {
        constexpr std::uint64_t kSample_bytes = 16'384;
        std::error_code failed;
        const std::uint64_t size = fs::file_size(file, failed);
        std::ifstream in(file, std::ios::binary);
        if (failed || !in)
            fail_to_name(file, "cannot be read");
        take(as.data(), as.size());
        take(&size, sizeof size);
        std::vector<char> sample(std::min(size, kSample_bytes));
        for (const std::uint64_t at : {std::uint64_t{0}, size - sample.size()}) {
            in.seekg(static_cast<std::streamoff>(at));
            if (!in.read(sample.data(), static_cast<std::streamsize>(sample.size())))
                fail_to_name(file, "cannot be read");
            take(sample.data(), sample.size());
        }
        ++m_files;
        m_bytes += size;
    }
    [[nodiscard]] std::string text() const {
        std::array<char, 20> hash{};
        std::snprintf(hash.data(), hash.size(), "%016llx", static_cast<unsigned long long>(m_hash));
        return std::to_string(m_files) + (m_files == 1 ? " file, " : " files, ") +
               std::to_string(m_bytes) + " bytes, " + hash.data();
    }

private:
    void take(const void* bytes, std::size_t count) noexcept {
        m_hash = XXH3_64bits_withSeed(bytes, count, m_hash);
    }
    std::uint64_t m_files = 0;
    std::uint64_t m_bytes = 0;
    std::uint64_t m_hash = 0;
};

void add_all(Contents& contents, const fs::path& path, const IsOutput& is_output = {}) {
    std::error_code failed;
    if (!fs::is_directory(path, failed))
        return contents.add(path, path.filename().string());
    const fs::path root = is_output ? fs::canonical(path, failed) : path;
    const auto counts = [&](const fs::path& file) {
        return !is_output || !is_output(root / file.lexically_relative(path));
    };
    std::vector<fs::path> files;
    for (fs::recursive_directory_iterator
             it(path, fs::directory_options::follow_directory_symlink, failed),
         end;
         !failed && it != end; it.increment(failed)) {
        const std::string name = it->path().filename().string();
        std::error_code ignored;
        if (is_passing(name))
            it.disable_recursion_pending();
        else if (it->is_regular_file(ignored) && counts(it->path()))
            files.push_back(it->path());
    }
    if (failed)
        fail_to_name(path, failed.message());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
        contents.add(file, file.lexically_relative(path).string());
}

std::string name_of(const fs::path& path, const IsOutput& is_output) {
    Contents contents;
    add_all(contents, path, is_output);
    const fs::path bare = path.has_filename() ? path : path.parent_path();
    return bare.filename().string() + ": " + contents.text();
}

}  // namespace

std::vector<std::string> name_inputs(const std::vector<std::string>& inputs,
                                     const std::vector<fs::path>& orthophotos,
                                     const scene::Scene& scene, const IsOutput& is_output) {
    std::vector<std::string> out;
    std::error_code ignored;
    for (const std::string& input : inputs)
        out.push_back(fs::exists(input, ignored) ? name_of(input, is_output) : input);
    for (const fs::path& photo : orthophotos)
        out.push_back("orthophoto " +
                      (fs::exists(photo, ignored) ? name_of(photo, is_output) : photo.string()));
    Contents shaping;
    add_all(shaping, material::find_materials(scene.quality.materials));
    for (const char* data : {"blocks", "classes", "palettes", "voxelize.toml"})
        if (const fs::path path = util::config_dir() / data; fs::exists(path, ignored))
            add_all(shaping, path);
    for (const std::string& given : {scene.world.settings, scene.world.classes})
        if (!given.empty() && fs::is_regular_file(given, ignored))
            add_all(shaping, given);
    out.push_back("configuration: " + shaping.text());
    return out;
}

}  // namespace terravox::farm
