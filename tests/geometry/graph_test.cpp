#include "geometry/graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "base/rng.h"

namespace rangegrasp::geometry {
namespace {

// Compares with labels that are all rewritten at every union.
TEST(UnionFind, JoinsAsRelabellingDoes) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    base::Rng rng(seed);
    constexpr std::uint32_t n = 40;
    UnionFind sets(n);
    std::vector<std::uint32_t> label(n);
    for (std::uint32_t i = 0; i < n; ++i) label[i] = i;
    for (int k = 0; k < 60; ++k) {
      const auto a = static_cast<std::uint32_t>(rng.Index(n));
      const auto b = static_cast<std::uint32_t>(rng.Index(n));
      EXPECT_EQ(sets.Unite(a, b), label[a] != label[b]);
      const std::uint32_t from = label[b];
      for (std::uint32_t& l : label) l = l == from ? label[a] : l;
      for (std::uint32_t i = 0; i < n; ++i) {
        EXPECT_EQ(sets.Find(i) == sets.Find(a), label[i] == label[a]);
      }
    }
  }
}

TEST(LabelBySize, NumbersTheUsedMembersLargestFirstTiesByFirstMember) {
  UnionFind sets(9);
  for (const auto& [a, b] : {std::pair(7u, 1u), {2u, 3u}, {3u, 8u}, {4u, 5u}}) sets.Unite(a, b);
  std::vector<std::int32_t> label;
  // {2, 3, 8} has one used member left, {1, 7} and {4, 5} have two, {0} and {6} are alone.
  const std::vector<bool> used{true, true, true, false, true, true, false, true, false};
  EXPECT_EQ(LabelBySize(sets, used, label), 4);
  EXPECT_EQ(label, (std::vector<std::int32_t>{2, 0, 3, -1, 1, 1, -1, 0, -1}));
}

using testing::ElementsAre;
using testing::IsEmpty;

const std::vector<std::pair<std::uint32_t, std::uint32_t>> kEdges = {{2, 1}, {0, 3}, {2, 0},
                                                                     {0, 1}, {2, 1}, {0, 3}};

TEST(Adjacency, EachNodeHasTheEndsOfItsEdgesAscendingAndOnce) {
  const Adjacency adjacency = MakeAdjacency(kEdges, 4);
  ASSERT_EQ(adjacency.nodes(), 4u);
  EXPECT_THAT(adjacency.Of(0), ElementsAre(1, 3));
  EXPECT_THAT(adjacency.Of(1), IsEmpty());
  EXPECT_THAT(adjacency.Of(2), ElementsAre(0, 1));
  EXPECT_THAT(adjacency.Of(3), IsEmpty());
  EXPECT_EQ(adjacency.to.size(), 4u);
}

TEST(Adjacency, OfNothingHasNoNodes) {
  EXPECT_EQ(Adjacency().nodes(), 0u);
  EXPECT_EQ(MakeAdjacency({}, 0).nodes(), 0u);
}

TEST(ContractGreedily, AFewEdgesForDoNotOutvoteTheBorderAgainst) {
  // Two pairs. One edge between them is positive; the others of their border are negative.
  const std::vector<SignedEdge> edges = {
      {0, 1, 5.0}, {2, 3, 5.0}, {1, 2, 1.0}, {0, 2, -2.0}, {1, 3, -2.0}};
  UnionFind parts = ContractGreedily(4, edges);
  EXPECT_EQ(parts.Find(0), parts.Find(1));
  EXPECT_EQ(parts.Find(2), parts.Find(3));
  EXPECT_NE(parts.Find(0), parts.Find(2));
}

TEST(ContractGreedily, ParallelEdgesAreSummed) {
  UnionFind apart = ContractGreedily(2, std::vector<SignedEdge>{{0, 1, 1.0}, {1, 0, -1.5}});
  EXPECT_NE(apart.Find(0), apart.Find(1));
  UnionFind joined = ContractGreedily(2, std::vector<SignedEdge>{{0, 1, 1.0}, {1, 0, -0.5}});
  EXPECT_EQ(joined.Find(0), joined.Find(1));
}

TEST(ContractGreedily, NamesWhatIsNoEdge) {
  EXPECT_THROW(ContractGreedily(2, std::vector<SignedEdge>{{0, 2, 1.0}}), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ContractGreedily(2, std::vector<SignedEdge>{{0, 1, nan}}), std::invalid_argument);
}

struct Link {
  std::uint32_t from, to;
  double length;
};

/// Links stored in compressed rows.
struct Graph {
  std::vector<std::uint32_t> begin, neighbor;
  std::vector<double> length;

  Graph(std::uint32_t nodes, std::vector<Link> links) : begin(nodes + 1, 0) {
    std::stable_sort(links.begin(), links.end(),
                     [](const Link& a, const Link& b) { return a.from < b.from; });
    for (const Link& link : links) {
      ++begin[link.from + 1];
      neighbor.push_back(link.to);
      length.push_back(link.length);
    }
    for (std::size_t v = 0; v < nodes; ++v) begin[v + 1] += begin[v];
  }
  LinkRows Rows() const { return {begin, neighbor, length}; }
  std::uint32_t Size() const { return static_cast<std::uint32_t>(begin.size() - 1); }
};

/// Random directed links. Some have length 0 and many have equal lengths, so there are many ties;
/// about half of the graphs are disconnected.
Graph RandomGraph(std::uint32_t nodes, base::Rng& rng, bool whole_lengths) {
  std::vector<Link> links(nodes + rng.Index(2 * nodes));
  for (Link& link : links) {
    link.from = static_cast<std::uint32_t>(rng.Index(nodes));
    link.to = static_cast<std::uint32_t>(rng.Index(nodes));
    link.length = whole_lengths ? static_cast<double>(rng.Index(4)) : rng.Uniform(0.0, 1.0);
  }
  return {nodes, links};
}

/// Bellman-Ford: relaxes every link until no distance gets shorter. The lengths are added in the
/// order of the path here, too, so even the rounding is the same.
std::vector<double> BellmanFord(const Graph& graph, const std::vector<std::uint32_t>& sources) {
  std::vector<double> distance(graph.Size(), kFar);
  for (const std::uint32_t source : sources) distance[source] = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t v = 0; v < graph.Size(); ++v) {
      for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
        if (distance[v] + graph.length[k] >= distance[graph.neighbor[k]]) continue;
        distance[graph.neighbor[k]] = distance[v] + graph.length[k];
        changed = true;
      }
    }
  }
  return distance;
}

/// Distances between all pairs of nodes (Floyd 1962, Warshall 1962).
std::vector<std::vector<double>> FloydWarshall(const Graph& graph) {
  const std::uint32_t n = graph.Size();
  std::vector<std::vector<double>> d(n, std::vector<double>(n, kFar));
  for (std::uint32_t v = 0; v < n; ++v) {
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      d[v][graph.neighbor[k]] = std::min(d[v][graph.neighbor[k]], graph.length[k]);
    }
    d[v][v] = 0.0;
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t j = 0; j < n; ++j) d[i][j] = std::min(d[i][j], d[i][k] + d[k][j]);
    }
  }
  return d;
}

std::vector<std::uint32_t> RandomNodes(std::uint32_t nodes, base::Rng& rng) {
  std::vector<std::uint32_t> some(1 + rng.Index(4));
  for (std::uint32_t& v : some) v = static_cast<std::uint32_t>(rng.Index(nodes));
  return some;
}

/// Reaches the neighbors of a node along its links.
auto Along(const Graph& graph) {
  return [&graph](std::uint32_t v, double d, const auto& reach) {
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      reach(graph.neighbor[k], d + graph.length[k]);
    }
  };
}

/// Nodes in the order in which they were expanded, with their distances.
using Order = std::vector<std::pair<double, std::uint32_t>>;
Order Expanded(const Graph& graph, const std::vector<std::uint32_t>& sources,
               std::vector<double>& distance, double max_distance = kFar) {
  Order order;
  distance.assign(graph.Size(), kFar);
  LowerDistances(
      sources, distance,
      [&](std::uint32_t v, double d, const auto& reach) {
        order.emplace_back(d, v);
        Along(graph)(v, d, reach);
      },
      max_distance);
  return order;
}

class SeededShortestPath : public testing::TestWithParam<std::uint64_t> {
 protected:
  base::Rng rng_{GetParam()};
};

// With integer lengths, sums are exact in any order.
TEST_P(SeededShortestPath, DistancesAreThoseBetweenAllPairs) {
  const Graph graph = RandomGraph(25, rng_, /*whole_lengths=*/true);
  const auto all = FloydWarshall(graph);
  for (std::uint32_t source = 0; source < graph.Size(); ++source) {
    EXPECT_EQ(DistancesFrom({{source}}, graph.Rows()), all[source]);
  }
}

TEST_P(SeededShortestPath, DistancesFromSeveralSourcesAreExactToTheLastBit) {
  const Graph graph = RandomGraph(60, rng_, /*whole_lengths=*/false);
  const auto sources = RandomNodes(graph.Size(), rng_);
  EXPECT_EQ(DistancesFrom(sources, graph.Rows()), BellmanFord(graph, sources));
}

TEST_P(SeededShortestPath, SourcesOneAfterTheOtherInAnyOrderGiveTheSameBits) {
  const Graph graph = RandomGraph(60, rng_, /*whole_lengths=*/false);
  auto sources = RandomNodes(graph.Size(), rng_);
  const auto together = DistancesFrom(sources, graph.Rows());
  std::reverse(sources.begin(), sources.end());
  std::vector<double> distance(graph.Size(), kFar);
  for (const std::uint32_t source : sources) LowerDistances({{source}}, distance, Along(graph));
  EXPECT_EQ(distance, together);
}

TEST_P(SeededShortestPath, NodesAreExpandedOnceNearestFirstAndTiesByNumber) {
  const Graph graph = RandomGraph(40, rng_, /*whole_lengths=*/true);
  const auto sources = RandomNodes(graph.Size(), rng_);
  std::vector<double> distance;
  const Order order = Expanded(graph, sources, distance);
  EXPECT_EQ(distance, BellmanFord(graph, sources));
  std::size_t reached = 0;
  for (const double d : distance) reached += d < kFar ? 1 : 0;
  EXPECT_EQ(order.size(), reached);
  for (std::size_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(order[i].first, distance[order[i].second]);
    // A link of length 0 may lead back to a node with a lower number.
    if (i > 0) {
      EXPECT_LE(order[i - 1].first, order[i].first);
    }
  }
}

// Compares with the textbook version without a heap, which searches all nodes for the next one.
TEST_P(SeededShortestPath, LabelsGoToTheSourceThatReachesFirst) {
  const Graph graph = RandomGraph(40, rng_, /*whole_lengths=*/true);
  const auto sources = RandomNodes(graph.Size(), rng_);
  const std::uint32_t n = graph.Size();
  std::vector<double> wanted_distance(n, kFar), distance(n, kFar);
  std::vector<int> wanted(n, -1);
  for (std::size_t s = 0; s < sources.size(); ++s) {
    wanted_distance[sources[s]] = 0.0;
    wanted[sources[s]] = static_cast<int>(s);
  }
  std::vector<int> label = wanted;
  std::vector<bool> done(n, false);
  for (std::uint32_t step = 0; step < n; ++step) {
    std::uint32_t v = n;
    for (std::uint32_t u = 0; u < n; ++u) {
      if (!done[u] && (v == n || wanted_distance[u] < wanted_distance[v])) v = u;
    }
    done[v] = true;
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      const std::uint32_t next = graph.neighbor[k];
      if (wanted_distance[v] + graph.length[k] >= wanted_distance[next]) continue;
      wanted_distance[next] = wanted_distance[v] + graph.length[k];
      wanted[next] = wanted[v];
    }
  }
  LowerDistances(sources, distance, [&](std::uint32_t v, double d, const auto& reach) {
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      if (reach(graph.neighbor[k], d + graph.length[k])) label[graph.neighbor[k]] = label[v];
    }
  });
  EXPECT_EQ(label, wanted);
  EXPECT_EQ(distance, wanted_distance);
}

TEST_P(SeededShortestPath, WithinTheMaximumAllIsAsWithoutItAndBeyondNothingIsExpanded) {
  const Graph graph = RandomGraph(60, rng_, /*whole_lengths=*/false);
  const auto sources = RandomNodes(graph.Size(), rng_);
  const auto all = BellmanFord(graph, sources);
  const double most = rng_.Uniform(0.0, 1.5);
  std::vector<double> distance;
  const Order order = Expanded(graph, sources, distance, most);
  for (const auto& [d, v] : order) EXPECT_LE(d, most);
  for (std::uint32_t v = 0; v < graph.Size(); ++v) {
    if (all[v] <= most) {
      EXPECT_EQ(distance[v], all[v]);
    }
    EXPECT_EQ(distance[v] <= most, all[v] <= most);
  }
}

// Each node has its own value, and the reached nodes come best first. The expected order comes
// from a search of the whole front at every step.
TEST_P(SeededShortestPath, AFloodFromOneNodeTakesTheBestOfItsFront) {
  const Graph graph = RandomGraph(40, rng_, /*whole_lengths=*/true);
  std::vector<double> value(graph.Size());
  for (double& v : value) v = static_cast<double>(rng_.Index(6));
  const auto start = static_cast<std::uint32_t>(rng_.Index(graph.Size()));
  std::vector<std::uint32_t> order, wanted;
  std::vector<double> reached(graph.Size(), kFar);
  LowerDistances({{start}}, reached, [&](std::uint32_t v, double, const auto& reach) {
    order.push_back(v);
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      reach(graph.neighbor[k], value[graph.neighbor[k]]);
    }
  });
  std::vector<bool> seen(graph.Size(), false);
  std::vector<std::uint32_t> front{start};
  seen[start] = true;
  while (!front.empty()) {
    const auto best = std::min_element(front.begin(), front.end(), [&](auto a, auto b) {
      return std::tuple(value[a], a) < std::tuple(value[b], b);
    });
    const std::uint32_t v = *best;
    front.erase(best);
    wanted.push_back(v);
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      if (seen[graph.neighbor[k]]) continue;
      seen[graph.neighbor[k]] = true;
      front.push_back(graph.neighbor[k]);
    }
  }
  EXPECT_EQ(order, wanted);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SeededShortestPath, testing::Range<std::uint64_t>(1, 101));

// On a 4-connected grid with links of length 1, the distance is the number of steps on both axes.
TEST(ShortestPath, OnAGridDistancesAreStepsAlongBothSides) {
  constexpr std::uint32_t kSide = 30;
  std::vector<Link> links;
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint32_t y = 0; y < kSide; ++y) {
      const std::uint32_t v = x * kSide + y;
      if (x + 1 < kSide) links.insert(links.end(), {{v, v + kSide, 1.0}, {v + kSide, v, 1.0}});
      if (y + 1 < kSide) links.insert(links.end(), {{v, v + 1, 1.0}, {v + 1, v, 1.0}});
    }
  }
  const Graph grid(kSide * kSide, links);
  const auto distance = DistancesFrom({{7 * kSide + 12}}, grid.Rows());
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint32_t y = 0; y < kSide; ++y) {
      EXPECT_EQ(distance[x * kSide + y], std::abs(7.0 - x) + std::abs(12.0 - y));
    }
  }
}

TEST(FarthestReached, IsTheLowestNodeOfTheLargestFiniteDistance) {
  EXPECT_EQ(FarthestReached(std::vector{1.0, 3.0, kFar, 3.0, 2.0}), 1u);
  EXPECT_EQ(FarthestReached(std::vector{kFar, kFar}), 0u);
  EXPECT_EQ(FarthestReached(std::vector{kFar, 0.0}), 1u);  // a source
  EXPECT_EQ(FarthestReached({}), 0u);
}

TEST(ShortestPath, WhereNoLinkLeadsTheDistanceIsInfinite) {
  const Graph graph(3, {{0, 1, 2.0}});
  EXPECT_EQ(DistancesFrom({{0U}}, graph.Rows()), (std::vector{0.0, 2.0, kFar}));
  EXPECT_EQ(DistancesFrom({}, graph.Rows()), (std::vector{kFar, kFar, kFar}));
  EXPECT_TRUE(DistancesFrom({}, Graph(0, {}).Rows()).empty());
}

}  // namespace
}  // namespace rangegrasp::geometry
