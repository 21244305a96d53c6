#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"

namespace terravox::voxelize {
namespace {

std::unique_ptr<store::SquareFolder> open_folder(const LidarWorldOptions& options) {
    if (options.cache_dir.empty())
        return nullptr;
    return std::make_unique<store::SquareFolder>(options.cache_dir / "squares",
                                                 options.cache_bytes);
}

std::unique_ptr<store::SquareFolder> open_indices(const LidarWorldOptions& options) {
    if (options.chunk_indices.empty())
        return nullptr;
    return std::make_unique<store::SquareFolder>(options.chunk_indices, store::kUnlimited_bytes);
}

std::vector<PartedFile> plan(std::span<const SquareSource> files, const PointMemory& memory,
                             const LoadContext& context, bool has_names) {
    const SquareRecipe recipe{context.frame, context.classes, context.settings};
    return plan_files(files, memory, has_names ? &recipe : nullptr);
}

std::vector<std::string> names_of(const std::vector<PartedFile>& files) {
    std::vector<std::string> out;
    out.reserve(files.size());
    for (const PartedFile& file : files)
        out.push_back(file.name);
    return out;
}

}  // namespace

SquareReader::SquareReader(const LidarWorldOptions& options, std::span<const SquareSource> files,
                           const PointMemory& memory, const LoadContext& context,
                           LoadReport& report)
    : m_times(context.times),
      m_report(report),
      m_folder(open_folder(options)),
      m_indices(open_indices(options)),
      m_files(plan(files, memory, context, m_folder != nullptr || m_indices != nullptr)),
      m_prepared(m_folder.get(), names_of(m_files)),
      m_parts(m_files, context, {m_folder.get(), m_indices.get(), options.reads_chunk_indices},
              memory.parts, thread::thread_count(options.threads),
              [&report](std::size_t file, const store::PointCounts& met, bool whole) {
                  whole ? report.add_whole(file, met) : report.add_part(file, met);
              }),
      m_decoder(
          m_files.size(),
          [this, context, threads = thread::thread_count(options.threads)](std::size_t file) {
              return load_square(*m_files[file].source, context, threads);
          },
          [this](std::size_t file, LoadedSquare loaded) { return keep(file, std::move(loaded)); }),
      m_squares(memory.squares),
      m_progress(m_files.size()) {}

Squares SquareReader::around(std::size_t file, const grid::PatchRect& wanted) {
    try {
        return read(file, wanted);
    } catch (const util::Error& e) {
        const std::lock_guard lock(m_mutex);
        m_progress[file].last_error = e.what();
        throw;
    }
}

std::pair<SquareState, std::string> SquareReader::state_of(std::size_t file) const {
    std::string error;
    bool in_memory = false;
    {
        const std::lock_guard lock(m_mutex);
        error = m_progress[file].last_error;
        in_memory = !m_progress[file].in_memory.expired();
    }
    if (in_memory || m_prepared.holds(file))
        return {SquareState::kPrepared, {}};
    if (!error.empty())
        return {SquareState::kFailed, std::move(error)};
    return {!m_files[file].kept_whole && m_parts.knows(file) ? SquareState::kPrepared
                                                             : SquareState::kFetched,
            {}};
}

Squares SquareReader::read(std::size_t file, const grid::PatchRect& wanted) {
    if (!m_files[file].kept_whole)
        return m_parts.around(file, wanted);
    if (auto square = m_squares.find(file))
        return {std::move(square)};
    if (m_prepared.holds(file) || !m_parts.are_enough(file, wanted))
        return {whole(file)};
    return m_parts.around(file, wanted);
}

std::shared_ptr<const store::Square> SquareReader::whole(std::size_t file) {
    auto found = m_squares.get(
        file, [&] { return find_or_decode(file); },
        [](const auto& s) { return s->memory_bytes(); });
    const std::lock_guard lock(m_mutex);
    m_progress[file].in_memory = found;
    return found;
}

std::shared_ptr<const store::Square> SquareReader::find_or_decode(std::size_t file) {
    auto square = m_prepared.find(file);
    if (!square)
        return m_decoder.decode(file);
    m_report.add_whole(file, square->counts());
    return square;
}

std::shared_ptr<const store::Square> SquareReader::keep(std::size_t file, LoadedSquare loaded) {
    m_report.add_whole(file, loaded.square->counts());
    if (!m_folder) {
        m_parts.learn(file, std::move(loaded.index));
        return loaded.square;
    }
    const util::StageTimes::Scope timed(m_times, "square store");
    m_parts.learn(file, std::move(loaded.index));
    return m_prepared.keep(file, std::move(loaded.square));
}

}  // namespace terravox::voxelize
