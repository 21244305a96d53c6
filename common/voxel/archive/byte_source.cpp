#include "common/voxel/archive/byte_source.hpp"

#include "common/util/error.hpp"
#include "common/util/mapped_file.hpp"

namespace terravox::voxel::archive {
namespace {

class FileSource final : public ByteSource {
public:
    explicit FileSource(const std::filesystem::path& path) : m_name(path.string()), m_file(util::MappedFile::open(path)) {
        if (!m_file) throw Error("open the box archive " + m_name + ": no such file");
    }
    [[nodiscard]] const std::string& name() const noexcept override { return m_name; }
    [[nodiscard]] std::span<const std::byte> read(std::uint64_t offset, std::size_t bytes, std::vector<std::byte>&) override {
        const auto all = m_file->bytes();
        if (offset > all.size() || bytes > all.size() - offset)
            throw Error("read the box archive " + m_name + ": bytes " + std::to_string(offset) + " to " + std::to_string(offset + bytes) + "; the file has " + std::to_string(all.size()));
        const auto part = all.subspan(static_cast<std::size_t>(offset), bytes);
        if (!util::readable(part)) throw Error("read the box archive " + m_name + ": it was cut short, or its disk fails");
        return part;
    }

private:
    const std::string m_name;
    const std::shared_ptr<const util::MappedFile> m_file;
};

}  // namespace

std::unique_ptr<ByteSource> file_source(const std::filesystem::path& path) { return std::make_unique<FileSource>(path); }

}  // namespace terravox::voxel::archive
