#include "voxelserver/out/archive/indexed_file.hpp"

#include <span>
#include <string>

#include "common/voxel/box_codec.hpp"
#include "voxelserver/out/archive/records.hpp"

namespace terravox::archive_tools {

using voxel::archive::MadeBox;
using voxel::archive::MadeRecord;

IndexedFile::IndexedFile(const std::filesystem::path& file, voxel::archive::ArchiveIndex::Of of)
    : m_source(voxel::archive::file_source(file)),
      m_index(std::make_unique<voxel::archive::ArchiveIndex>(*m_source, of)),
      m_finder(std::make_unique<voxel::archive::EntryFinder>(*m_index)) {}

MadeRecord IndexedFile::record(const voxel::archive::Entry& entry) const {
    MadeRecord out{voxel::archive::key_of(entry.key), entry.kind, {}};
    read_records(*m_source, std::span(&entry, 1), "read",
                 [&](const voxel::archive::Entry&, std::span<const std::byte> frame) {
                     out.frame.assign(frame.begin(), frame.end());
                 });
    return out;
}

MadeBox IndexedFile::box(const voxel::archive::Entry& entry) const {
    const MadeRecord made = record(entry);
    const std::string name = m_source->name() + " box " + voxel::to_string(made.key);
    if (made.kind == voxel::archive::Kind::kHole)
        return {nullptr,
                std::string(reinterpret_cast<const char*>(made.frame.data()), made.frame.size())};
    return {voxel::decompress_box(made.frame, name), std::nullopt};
}

}  // namespace terravox::archive_tools
