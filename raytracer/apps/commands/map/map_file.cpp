#include "raytracer/apps/commands/map/map_file.hpp"

#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"
#include "raytracer/core/output/gdal_writing.hpp"

namespace terravox::commands {
namespace {

std::filesystem::path with_ending(std::filesystem::path file, const char* ending) {
    return file.replace_extension(ending);
}

}  // namespace

bool MapFileOptions::in_tiles() const {
    return util::lower_extension(file) == ".pmtiles";
}

void check_map_target(const MapFileOptions& options) {
    const std::string ending = util::lower_extension(options.file);
    if (ending != ".tif" && ending != ".tiff" && ending != ".pmtiles")
        throw util::UsageError("write the map " + options.file.string() + ": the ending '" +
                               ending + "'; allowed: .tif .tiff .pmtiles");
    util::check_writable(options.file);
    if (options.in_tiles())
        pmtiles::check_tile_format(options.tiles);
}

MapFile::MapFile(MapFileOptions options, const output::StreamShape& shape,
                 const output::PictureInfo& info)
    : m_options(std::move(options)) {
    m_picture.emplace(with_ending(m_options.file, ".picture.tif"));
    m_stream = std::make_unique<output::TileStream>(m_picture->temporary_path(), shape, info);
}

void MapFile::write_overviews(const std::filesystem::path& to) {
    const output::GdalWatch watch("write the map " + m_options.file.string());
    output::GdalDataset picture(
        GDALOpen(m_picture->temporary_path().string().c_str(), GA_ReadOnly));
    watch.check(picture != nullptr);
    output::CogOptions options;
    options.threads = std::to_string(m_options.threads);
    options.is_stopped = m_options.is_stopped;
    output::write_cog(picture.get(), to, options, watch);
    picture.reset();
    m_picture.reset();
}

std::uint64_t MapFile::write(const pmtiles::MapTexts& texts) {
    m_stream->finish(texts.holes);
    if (!m_options.in_tiles()) {
        util::AtomicFile target(m_options.file);
        write_overviews(target.temporary_path());
        target.commit();
        return 0;
    }
    // Coarse tiles are made of the overviews.
    const util::AtomicFile map(with_ending(m_options.file, ".map.tif"));
    write_overviews(map.temporary_path());
    return pmtiles::write_map_tiles(map.temporary_path(), m_options.area, m_options.file,
                                    m_options.tiles, texts, m_options.threads, m_options.quiet,
                                    m_options.is_stopped);
}

}  // namespace terravox::commands
