#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

namespace livermark::tests {

namespace {

/// The good mesh, spoilt or replaced.
BadInput mesh(std::string name, std::string what, std::string text, std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "mesh check two.msh",
            .file = "two.msh:",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"two.msh", std::move(text)}}};
}

BadInput spoilt_mesh(std::string name, std::string what, const std::string &from, const std::string &to,
                     std::string place, std::string remedy) {
    return mesh(std::move(name), std::move(what), replaced(good_msh, from, to), std::move(place), std::move(remedy));
}

std::string up_to(const std::string &end) {
    return good_msh.substr(0, good_msh.find(end));
}

} // namespace

std::vector<BadInput> bad_meshes() {
    const std::string two = "2 4 2 1 1 1 2 3 4\n3 4 2 1 1 2 3 4 5\n";
    return {
        {.name = "MissingMesh",
         .what = "a mesh that is not there",
         .arguments = "mesh check nowhere.msh",
         .file = "nowhere.msh:",
         .place = "",
         .remedy = "check the path"},
        mesh("EmptyMesh", "an empty mesh", "", "", "save it again"),
        mesh("RandomBytes", "random bytes as a mesh", random_bytes(), ":1:", "$MeshFormat has to come first"),
        mesh("FirstMshWithTooFewNodes", "a tetrahedron of three nodes in MSH 1",
             "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n1 4 1 1 3 1 2 3\n$ENDELM\n",
             ":10: element 1", "correct it"),
        mesh("TruncatedFirstMsh", "a mesh in MSH 1 that ends in its nodes", "$NOD\n4\n1 0 0 0\n2 1 0",
             ":4:", "save it again"),
        mesh("TruncatedInANode", "a mesh that ends in a node", up_to(" 0 1\n5"), ":14:", "save it again"),
        mesh("TruncatedBetweenSections", "a mesh that ends before its elements", up_to("$Elements"),
             "there are no tetrahedra", "mesh the volume"),
        spoilt_mesh("NanCoordinate", "NaN as a coordinate", "2 1 0 0\n", "2 1 nan 0\n", "node 2", "correct it"),
        spoilt_mesh("DecimalComma", "decimal commas", "3 0 1 0\n", "3 0 0,5 0\n", ":13:", "has to be a number"),
        spoilt_mesh("InvertedTetrahedron", "an inverted tetrahedron", "1 1 2 3 4\n", "1 2 1 3 4\n", "tetrahedron 2",
                    "exchange two of its nodes"),
        spoilt_mesh("FlatTetrahedron", "a flat tetrahedron", "4 0 0 1\n", "4 0.5 0.5 0\n", "tetrahedron 2",
                    "remesh there"),
        mesh("TetrahedronTwice", "a tetrahedron that is there twice",
             replaced(replaced(good_msh, "$Elements\n3\n", "$Elements\n4\n"), two, two + "4 4 2 1 1 3 1 2 4\n"),
             "tetrahedra 2 and 4", "remove one"),
        spoilt_mesh("NodeNumberTwice", "two nodes of one number", "3 0 1 0\n", "2 0 1 0\n", ":13: node 2",
                    "remove one"),
        spoilt_mesh("NodesInOnePlace", "two nodes in one place", "5 1 1 1\n", "5 0 0 1\n", "node 4 and node 5",
                    "merge them"),
        spoilt_mesh("UnusedNode", "a node that no tetrahedron has", "3 4 2 1 1 2 3 4 5\n", "3 15 2 1 1 5\n", "node 5",
                    "remove it"),
        spoilt_mesh("NodeOutOfRange", "a tetrahedron with a node that is not there", "2 3 4 5\n", "2 3 4 9\n",
                    ":21: there is no node 9", "correct the element"),
        mesh("DisconnectedParts", "two parts that do not touch",
             replaced(replaced(good_msh, "5\n1 0 0 0\n", "8\n6 5 0 0\n7 5 1 0\n8 5 0 1\n1 0 0 0\n"), "2 3 4 5\n",
                      "7 6 8 5\n"),
             "node 6 and node 1", "keep one part"),
        mesh("FaceOfThreeTetrahedra", "three tetrahedra on one face",
             replaced(replaced(replaced(good_msh, "5\n1 0 0 0\n", "6\n6 2 2 2\n1 0 0 0\n"), "$Elements\n3\n",
                               "$Elements\n4\n"),
                      "2 3 4 5\n", "2 3 4 5\n4 4 2 1 1 2 3 4 6\n"),
             "the face of nodes 2 3 4", "remesh without overlaps"),
        mesh("PartsThatHangOnAnEdge", "two parts that hang on an edge",
             replaced(replaced(replaced(good_msh, "5\n1 0 0 0\n", "6\n6 0 -1 0\n1 0 0 0\n"), "5 1 1 1\n", "5 0 0 -1\n"),
                      "2 3 4 5\n", "1 6 5 2\n"),
             "tetrahedra 2 and 3", "join them by faces"),
        mesh("TriangleInTwoPatches", "a triangle in two patches",
             replaced(replaced(good_msh, "$Elements\n3\n", "$Elements\n4\n"), two, two + "4 2 2 7 1 1 2 3\n"),
             "nodes 1 2 3", "keep one"),
        spoilt_mesh("QuadraticElements", "quadratic tetrahedra", "3 4 2 1 1 2 3 4 5\n",
                    "3 11 2 1 1 2 3 4 5 1 2 3 4 5 1\n", ":21: element 3", "order 1"),
        spoilt_mesh("BinaryMesh", "text in a mesh that says it is binary", "2.2 0 8", "2.2 1 8", "cannot be converted",
                    "save it as ASCII MSH"),
        spoilt_mesh("PartitionedMesh", "a mesh in partitions", "$Nodes", "$PartitionedEntities",
                    ":9:", "save it in one part"),
        spoilt_mesh("TooManyNodes", "five billion nodes", "$Nodes\n5\n", "$Nodes\n5000000000\n", ":10: 5000000000",
                    "give a number from 0"),
        spoilt_mesh("MoreNodesThanThereAre", "more nodes announced than there are", "$Nodes\n5\n",
                    "$Nodes\n2000000000\n", ":16:", "has to be an integer"),
    };
}

} // namespace livermark::tests
