#include "voxelserver/make/worlds/minecraft/source.hpp"

#include <zip.h>

#include <algorithm>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/handle_pool.hpp"

namespace terravox::minecraft {
namespace {

// Unpacked files larger than this go to disk, and only they are checked for bombs: a region's
// chunks are packed already, so that it hardly packs further. A high ratio is never a region.
constexpr std::uint64_t kLargeBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kMaxRatio = 200;
constexpr std::size_t kStepBytes = std::size_t{1} << 20;
constexpr std::size_t kTemporaryFileWeight = std::size_t{16} << 20;

class MemoryFile final : public ByteFile {
public:
    MemoryFile(std::vector<std::uint8_t> bytes, std::string name)
        : m_bytes(std::move(bytes)), m_name(std::move(name)) {}
    std::uint64_t size() const noexcept override { return m_bytes.size(); }
    void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
        if (offset > m_bytes.size() || out.size() > m_bytes.size() - offset)
            throw util::Error("read {}: it ends at byte {}", m_name, m_bytes.size());
        if (!out.empty())
            std::memcpy(out.data(), m_bytes.data() + offset, out.size());
    }

private:
    std::vector<std::uint8_t> m_bytes;
    std::string m_name;
};

/// Appends to a temporary file, which is made with its first bytes.
void append(util::Descriptor& file, std::span<const std::uint8_t> bytes) {
    if (file.get() < 0)
        file = util::Descriptor(util::open_unnamed(
            std::filesystem::temp_directory_path() / "terravox-region", "make a temporary file"));
    if (const int failed = util::write_all(file.get(), std::as_bytes(bytes)); failed != 0)
        throw util::Error(std::string("write a temporary file: ") + std::strerror(failed));
}

struct CloseZip {
    void operator()(zip_t* zip) const noexcept { zip_discard(zip); }
};
struct CloseEntry {
    void operator()(zip_file_t* file) const noexcept { zip_fclose(file); }
};
using Zip = std::unique_ptr<zip_t, CloseZip>;
using ZipEntry = std::unique_ptr<zip_file_t, CloseEntry>;

// @return the normalized path, or empty when it leads outside
std::string safe_path(std::string path) {
    std::replace(path.begin(), path.end(), '\\', '/');
    if (path.empty() || path.front() == '/' || (path.size() > 1 && path[1] == ':'))
        return {};
    std::string out;
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('/', begin), path.size());
        const std::string part = path.substr(begin, end - begin);
        if (part == "..")
            return {};
        if (!part.empty() && part != ".")
            out += (out.empty() ? "" : "/") + part;
        begin = end + 1;
    }
    return out;
}

/// A handle of libzip serves one thread at a time: each thread that unpacks takes an idle one, or
/// opens another.
class ZipSource final : public FileSource {
public:
    ZipSource(std::filesystem::path path, std::size_t cache_bytes)
        : FileSource(cache_bytes), m_path(std::move(path)) {
        list(*m_zips.borrow([this] { return open_handle(); }));
    }
    std::vector<std::uint8_t> head(std::size_t entry, std::size_t most) override {
        std::vector<std::uint8_t> out;
        unpack(entry, std::clamp<std::size_t>(most, 1, kStepBytes),
               [&](std::span<const std::uint8_t> bytes) {
                   out.insert(out.end(), bytes.begin(),
                              bytes.begin() + static_cast<std::ptrdiff_t>(
                                                  std::min(bytes.size(), most - out.size())));
                   return out.size() < most;
               });
        return out;
    }

private:
    Opened open_anew(std::size_t entry) override {
        const std::string name = m_path.string() + ": " + m_entries[entry].path;
        std::vector<std::uint8_t> memory;
        util::Descriptor disk;
        unpack(entry, kStepBytes, [&](std::span<const std::uint8_t> bytes) {
            if (disk.get() < 0 && memory.size() + bytes.size() > kLargeBytes) {
                append(disk, memory);
                memory = {};
            }
            if (disk.get() >= 0)
                append(disk, bytes);
            else
                memory.insert(memory.end(), bytes.begin(), bytes.end());
            return true;
        });
        if (disk.get() >= 0)
            return {std::make_shared<DiskFile>(std::move(disk), name), kTemporaryFileWeight};
        memory.shrink_to_fit();
        const std::size_t weight = memory.size();
        return {std::make_shared<MemoryFile>(std::move(memory), name), weight};
    }

    Zip open_handle() const {
        int code = 0;
        Zip zip(zip_open(m_path.c_str(), ZIP_RDONLY, &code));
        if (zip != nullptr)
            return zip;
        zip_error_t error;
        zip_error_init_with_code(&error, code);
        const std::string why = zip_error_strerror(&error);
        zip_error_fini(&error);
        throw util::Error("open the ZIP file {}: {}", m_path.string(), why);
    }

    void list(zip_t& zip) {
        const zip_int64_t count = zip_get_num_entries(&zip, 0);
        if (count > static_cast<zip_int64_t>(kMaxEntries))
            throw util::Error("open the ZIP file {}: {} files; allowed: up to {}", m_path.string(),
                              count, kMaxEntries);
        std::vector<Entry> entries;
        std::vector<std::string> refused;
        for (zip_int64_t i = 0; i < count; ++i) {
            zip_stat_t status;
            if (zip_stat_index(&zip, static_cast<zip_uint64_t>(i), 0, &status) != 0 ||
                (status.valid & ZIP_STAT_NAME) == 0)
                continue;
            const std::string name = status.name;
            const std::string path = safe_path(name);
            if (path.empty()) {
                refused.push_back("'" + name + "' leads outside the ZIP file");
            } else if (name.back() != '/' && name.back() != '\\') {
                if (!m_index.emplace(path, i).second)
                    refused.push_back("'" + name +
                                      "' stands in the ZIP file twice: the first counts");
                else
                    entries.push_back(
                        {path, (status.valid & ZIP_STAT_SIZE) != 0 ? status.size : 0});
            }
        }
        set_entries(std::move(entries), std::move(refused));
    }

    // Passes on the bytes piece by piece, until take() reports that it has enough.
    template <class Take>
    void unpack(std::size_t entry, std::size_t step_bytes, const Take& take) {
        const std::string& path = m_entries[entry].path;
        auto zip = m_zips.borrow([this] { return open_handle(); });
        const auto fail = [&](const std::string& why) {
            zip.drop();
            throw util::Error("unpack {} of {}: {}", path, m_path.string(), why);
        };
        const auto index = static_cast<zip_uint64_t>(m_index.at(path));
        zip_stat_t status;
        if (zip_stat_index(zip.get(), index, 0, &status) != 0)
            fail(zip_strerror(zip.get()));
        ZipEntry file(zip_fopen_index(zip.get(), index, 0));
        if (file == nullptr)
            fail(zip_strerror(zip.get()));
        std::vector<std::uint8_t> step(step_bytes);
        for (std::uint64_t total = 0;;) {
            const zip_int64_t got = zip_fread(file.get(), step.data(), step.size());
            if (got < 0)
                fail(zip_file_strerror(file.get()));
            if (got == 0)
                break;
            total += static_cast<std::uint64_t>(got);
            if (total > kMaxFileBytes)
                fail("more than " + std::to_string(kMaxFileBytes >> 20) +
                     " MiB, the most that is allowed");
            if (total > kLargeBytes && (status.valid & ZIP_STAT_COMP_SIZE) != 0 &&
                total / kMaxRatio > status.comp_size)
                fail("more than " + std::to_string(kMaxRatio) +
                     " times its packed size; allowed: less");
            if (!take(std::span<const std::uint8_t>(step.data(), static_cast<std::size_t>(got))))
                break;
        }
    }

    std::filesystem::path m_path;
    std::unordered_map<std::string, zip_int64_t> m_index;
    util::HandlePool<Zip> m_zips;
};

}  // namespace

std::unique_ptr<FileSource> open_zip(const std::filesystem::path& path, std::size_t cache_bytes) {
    return std::make_unique<ZipSource>(path, cache_bytes);
}

}  // namespace terravox::minecraft
