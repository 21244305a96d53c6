#include "raytracer/farm/checkpoint/joined_tiles.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <span>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::farm {
namespace {

/// Opens for reading, unless a coordinator is writing to it.
OpenFile opened(const std::filesystem::path& path) {
    OpenFile file(path, O_RDONLY, "join the checkpoint");
    if (::flock(file.fd(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        throw util::Error("join the checkpoint " + path.string() +
                          ": a coordinator is writing to it; merge when it has ended");
    return file;
}

}  // namespace

JoinedTiles::JoinedTiles(const std::vector<std::filesystem::path>& files) {
    if (files.empty())
        throw util::UsageError("join checkpoints: none named; allowed: one and more");
    for (const auto& path : files) {
        m_journals.emplace_back(opened(path));
        const TileJournal& journal = m_journals.back();
        if (const std::string differs = difference(key(), journal.key()); !differs.empty())
            throw util::Error("join the checkpoint " + path.string() +
                              ": of another picture than " + files.front().string() +
                              ", which is \"there\": " + differs);
        if (const std::string damaged = journal.what_is_damaged(); !damaged.empty())
            util::log_warn("{}", damaged);
        m_damage.insert(journal.damage().begin(), journal.damage().end());
    }
    m_journal_of.assign(key().grid.cells(), kNoJournal);
    for (std::uint32_t j = 0; j < m_journals.size(); ++j)
        for (std::uint32_t cell = 0; cell < m_journal_of.size(); ++cell) {
            if (!m_journals[j].at(cell).is_there())
                continue;
            if (m_journal_of[cell] != kNoJournal)
                compare(cell, j);
            else {
                m_journal_of[cell] = j;
                ++m_count;
            }
        }
}

void JoinedTiles::compare(std::uint32_t cell, std::uint32_t other) {
    const TileJournal &own = m_journals[m_journal_of[cell]], &its = m_journals[other];
    const std::uint32_t own_holes = own.at(cell).holes;
    const std::uint32_t its_holes = its.at(cell).holes;
    if (own_holes > 0 || its_holes > 0) {
        if (its_holes < own_holes)
            m_journal_of[cell] = other;
        return;
    }
    if (tiles::hash_of_pixels(own.tile(cell)) == tiles::hash_of_pixels(its.tile(cell)))
        return;
    const TileGrid& grid = key().grid;
    throw util::Error("join the checkpoint " + its.file().path().string() +
                      ": the tile in column " + std::to_string(cell % grid.columns() + 1) +
                      ", row " + std::to_string(cell / grid.columns() + 1) +
                      " shows something else than in " + own.file().path().string() +
                      "; one of the two is wrong");
}

std::string JoinedTiles::rows_missing() const {
    return terravox::farm::rows_missing(
        key().grid, [this](std::uint32_t cell) { return m_journal_of[cell] != kNoJournal; });
}

void JoinedTiles::each(const std::function<void(tiles::TileResult&&)>& take) const {
    for (std::uint32_t cell = 0; cell < m_journal_of.size(); ++cell)
        if (m_journal_of[cell] != kNoJournal)
            take(m_journals[m_journal_of[cell]].tile(cell));
}

void JoinedTiles::write(const std::filesystem::path& file) const {
    // Before any work is done; commit_as_new() asks again.
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored))
        throw util::UsageError("write " + file.string() +
                               ": it is there already; allowed: another name");
    util::AtomicFile out(file);
    out.append(file_head(key().to_json()));
    const auto append = [&](RecordKind kind, std::uint32_t cell,
                            std::span<const std::byte> payload) {
        out.append(record_head(kind, cell, payload));
        out.append(payload);
    };
    std::string lines;
    for (const std::string& line : m_damage)
        lines += line + "\n";
    if (!lines.empty())
        append(RecordKind::kDamage, 0, std::as_bytes(std::span(lines)));
    for (std::uint32_t cell = 0; cell < m_journal_of.size(); ++cell)
        if (m_journal_of[cell] != kNoJournal)
            append(RecordKind::kTile, cell, m_journals[m_journal_of[cell]].encoded(cell));
    out.commit_as_new();
}

std::string rows_missing(const TileGrid& grid, const std::function<bool(std::uint32_t)>& is_there) {
    std::string out;
    const auto lacks = [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < grid.columns(); ++column)
            if (!is_there(row * grid.columns() + column))
                return true;
        return false;
    };
    for (std::uint32_t row = 0; row < grid.rows(); ++row) {
        if (!lacks(row))
            continue;
        const std::uint32_t first = row;
        while (row + 1 < grid.rows() && lacks(row + 1))
            ++row;
        out += (out.empty() ? "" : ", ") + std::to_string(first + 1) +
               (row > first ? (row == first + 1 ? ", " : " to ") + std::to_string(row + 1) : "");
    }
    return out;
}

}  // namespace terravox::farm
