#include "voxelserver/make/voxelize/columns/whole_decoder.hpp"

#include "common/util/error.hpp"

namespace terravox::voxelize {

WholeDecoder::WholeDecoder(std::size_t files, Load load, Keep keep)
    : m_load(std::move(load)), m_keep(std::move(keep)), m_failures(files) {}

std::shared_ptr<const store::Square> WholeDecoder::decode(std::size_t file) {
    const std::lock_guard lock(m_mutex);
    if (!m_failures[file].empty())
        throw util::Error(m_failures[file]);
    return m_keep(file, load(file));
}

LoadedSquare WholeDecoder::load(std::size_t file) {
    try {
        return m_load(file);
    } catch (const util::Error& e) {
        m_failures[file] = e.what();
        throw;
    }
}

}  // namespace terravox::voxelize
