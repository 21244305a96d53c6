#include "raytracer/farm/checkpoint/tile_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <algorithm>
#include <cerrno>
#include <span>
#include <sstream>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"

namespace terravox::farm {

TileJournal::TileJournal(OpenFile file) : m_file(std::move(file)) {
    const auto prepare = [this](const std::string& text) {
        if (!m_entries.empty())
            return;
        m_key = PictureKey::from_json(text, m_file.path().string());
        m_entries.resize(m_key.grid.cells());
    };
    const RecordScan scan = scan_records(m_file, [&](const std::string& text, const Record& record,
                                                     std::span<const std::byte> payload) {
        prepare(text);
        return take(record, payload);
    });
    prepare(scan.text);
    for (const Record& record : scan.damaged)
        m_damaged.insert(record.cell);
    m_lost_bytes = scan.lost_bytes;
    m_end = scan.end;
}

bool TileJournal::take(const Record& record, std::span<const std::byte> payload) {
    if (record.kind == RecordKind::kDamage) {
        note_damage({reinterpret_cast<const char*>(payload.data()), payload.size()});
        return true;
    }
    if (record.cell >= m_entries.size())
        return false;
    if (record.kind == RecordKind::kForgotten) {
        note(record, 0);
        return true;
    }
    if (record.kind != RecordKind::kTile)
        return false;
    try {
        const tiles::TileHead head = tiles::read_tile_head(payload, m_file.path().string());
        if (m_key.grid.find_cell(head.tile) != record.cell ||
            head.content.layers != m_key.with_layers)
            return false;
        note(record, head.holes);
    } catch (const util::Error&) {
        return false;  // reported as damage, with all the others
    }
    return true;
}

void TileJournal::note(const Record& record, std::uint32_t holes) {
    Entry& entry = m_entries.at(record.cell);
    m_count -= entry.is_there() ? 1 : 0;
    entry = record.kind == RecordKind::kTile ? Entry{record.offset, record.bytes, holes} : Entry{};
    m_count += entry.is_there() ? 1 : 0;
}

void TileJournal::note_damage(const std::string& lines) {
    std::istringstream in(lines);
    for (std::string line; std::getline(in, line);)
        if (!line.empty())
            m_damage.insert(line);
}

std::vector<std::byte> TileJournal::encoded(std::uint32_t cell) const {
    const Entry& entry = at(cell);
    std::vector<std::byte> bytes(entry.bytes);
    m_file.read(entry.offset, bytes);
    return bytes;
}

tiles::TileResult TileJournal::tile(std::uint32_t cell) const {
    return tiles::decode_tile(encoded(cell),
                              std::to_string(cell) + " of " + m_file.path().string());
}

std::string TileJournal::what_is_damaged() const {
    const auto tiles =
        std::count_if(m_damaged.begin(), m_damaged.end(), [this](std::uint32_t cell) {
            return cell >= m_entries.size() || !m_entries[cell].is_there();
        });
    std::string out;
    if (tiles > 0)
        out = std::to_string(tiles) + (tiles == 1 ? " tile" : " tiles");
    if (m_lost_bytes > 0)
        out += (out.empty() ? "" : ", and ") + std::to_string(m_lost_bytes) +
               " bytes that cannot be interpreted";
    return out.empty() ? out : m_file.path().string() + " is damaged: " + out;
}

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
